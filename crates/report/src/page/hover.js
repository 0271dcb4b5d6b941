'use strict';
// Values under the pointer, and lines that can be switched off. Without this the page shows the same.
for (const figure of document.querySelectorAll('figure')) {
  const names = new Map();
  for (const key of figure.querySelectorAll('.legend [data-k]')) {
    names.set(key.dataset.k, key.textContent.trim());
    key.tabIndex = 0;
    key.setAttribute('role', 'button');
    key.setAttribute('aria-pressed', 'true');
    const flip = () => {
      const off = key.classList.toggle('off');
      key.setAttribute('aria-pressed', String(!off));
      for (const line of figure.querySelectorAll('.plot [data-k="' + key.dataset.k + '"]')) {
        line.classList.toggle('off', off);
      }
    };
    key.addEventListener('click', flip);
    key.addEventListener('keydown', event => {
      if (event.key === 'Enter' || event.key === ' ') { event.preventDefault(); flip(); }
    });
  }
  figure.querySelectorAll('svg[data-x]').forEach(chart => readable(chart, names));
}

function readable(chart, names) {
  const frame = chart.querySelector('.plot'), log = chart.dataset.log || '';
  const [left, top, width, height] = ['x', 'y', 'width', 'height'].map(side => Number(frame.getAttribute(side)));
  const value = (axis, part) => {
    const [from, to] = chart.dataset[axis].split(' ').map(Number), at = from + part * (to - from);
    const v = log.includes(axis) ? 10 ** at : at;
    return Math.abs(v) < 1e-9 * Math.abs(to - from) ? '0' : String(Number(v.toPrecision(4)));
  };
  const lines = [...frame.querySelectorAll('polyline')].map(line => {
    const points = line.getAttribute('points').split(' ').map(p => p.split(',').map(Number));
    const ordered = points.every((p, i) => i === 0 || p[0] >= points[i - 1][0]);
    return { line, points, ordered, name: names.get(line.dataset.k) || '' };
  });
  let cursor = null, tip = null;
  const leave = () => { cursor?.remove(); tip?.remove(); cursor = tip = null; };
  chart.addEventListener('pointerleave', leave);
  chart.addEventListener('pointermove', event => {
    leave();
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(chart.getScreenCTM().inverse());
    const x = at.x - left, y = at.y - top;
    if (x < 0 || x > width || y < 0 || y > height) return;
    const rows = lines.filter(l => !l.line.classList.contains('off')).flatMap(l => under(l, x, y));
    if (rows.length === 0) return;
    const here = rows.every(row => row.x === x);
    cursor = document.createElementNS('http://www.w3.org/2000/svg', 'path');
    cursor.setAttribute('class', 'cursor');
    cursor.setAttribute('d', here ? `M${x} 0V${height}` : rows.map(r => `M${r.x - 4} ${r.y}h8m-4 -4v8`).join(''));
    frame.append(cursor);
    tip = document.createElement('div');
    tip.className = 'tip';
    const say = words => tip.append(Object.assign(document.createElement('div'), { textContent: words }));
    if (here) say('at ' + value('x', x / width));
    for (const row of rows) {
      const up = value('y', 1 - row.y / height);
      say((row.name ? row.name + ': ' : '') + (here ? up : value('x', row.x / width) + ', ' + up));
    }
    document.body.append(tip);
    const room = document.documentElement.clientWidth - tip.offsetWidth - 8;
    tip.style.left = scrollX + Math.max(0, Math.min(event.clientX + 14, room)) + 'px';
    tip.style.top = scrollY + event.clientY + 14 + 'px';
  });
}

// Where a line is at x, or, of one that runs back and forth, its point nearest to the pointer if that is near.
function under({ points, ordered, name }, x, y) {
  if (!ordered) {
    const far = p => Math.hypot(p[0] - x, p[1] - y);
    const near = points.reduce((a, b) => far(b) < far(a) ? b : a);
    return far(near) > 20 ? [] : [{ name, x: near[0], y: near[1] }];
  }
  const i = points.findIndex(p => p[0] >= x);
  if (i < 0 || (i === 0 && points[0][0] > x)) return [];
  const [a, b] = [points[Math.max(i - 1, 0)], points[i]];
  const part = b[0] > a[0] ? (x - a[0]) / (b[0] - a[0]) : 1;
  return [{ name, x, y: a[1] + part * (b[1] - a[1]) }];
}
