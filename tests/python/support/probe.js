// Put at the end of a page: looks at it as a person would, and writes what it finds where `--dump-dom` shows it.
addEventListener('load', () => {
  const edge = document.documentElement.clientWidth;
  const scrolls = element => element.closest('.table, .plot') !== null;
  const drawn = chart => [...chart.querySelectorAll('.plot > *')].some(curve => {
    const box = curve.getBBox();
    return box.width + box.height > 1 && box.x < 1000 && box.y < 1000;
  });
  const points = chart => {
    const box = chart.getBoundingClientRect();
    chart.scrollIntoView();
    const at = chart.getBoundingClientRect();
    const [clientX, clientY] = [at.x + 0.6 * at.width, at.y + 0.5 * at.height];
    chart.dispatchEvent(new PointerEvent('pointermove', { clientX, clientY }));
    const shown = document.querySelector('.tip')?.textContent ?? '';
    chart.dispatchEvent(new PointerEvent('pointerleave'));
    return { label: chart.getAttribute('aria-label'), drawn: drawn(chart), shown, width: box.width };
  };
  const switches = figure => {
    const key = figure.querySelector('.legend [role=button]');
    if (key === null) return true;
    const lines = () => [...figure.querySelectorAll('.plot [data-k="' + key.dataset.k + '"]')];
    const shown = () => lines().filter(line => getComputedStyle(line).display !== 'none').length;
    const before = shown();
    key.click();
    const off = shown();
    key.click();
    return before > 0 && off === 0 && shown() === before;
  };
  const figures = [...document.querySelectorAll('figure:not(.diagram)')];
  const found = {
    problems: window.problems,
    width: innerWidth,
    scrollWidth: document.documentElement.scrollWidth,
    over: [...document.querySelectorAll('body *')]
      .filter(element => element.getBoundingClientRect().right > edge + 1 && !scrolls(element))
      .map(element => element.tagName + ' ' + element.textContent.slice(0, 40)),
    paper: getComputedStyle(document.body).backgroundColor,
    ink: getComputedStyle(document.querySelector('figure text')).fill,
    figures: figures.map(figure => ({
      id: figure.id,
      switches: switches(figure),
      charts: [...figure.querySelectorAll('.charts > svg')].map(points),
    })),
  };
  const place = document.createElement('pre');
  place.id = 'probe';
  place.textContent = JSON.stringify(found);
  parent.document.body.append(place);
});
