"""The control law as a slave of pythonfmu, with NumPy; `law.json` is in the FMU's resources."""

import json
from pathlib import Path

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Peer(Fmi2Slave):
    """A slave with one tick per step."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        law = json.loads((Path(self.resources) / "law.json").read_text(encoding="utf-8"))
        self.law = {name: np.array(value) for name, value in law.items()}
        self.x = np.zeros(len(law["A"]))
        self.unit = np.eye(len(law["Dtt"]))
        self.filtered = 0.0
        for name in ("pitch", "speed", "pitch_rate", "pitch_reference", "speed_reference"):
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for index in range(len(law["Cu"])):
            setattr(self, f"command{index}", 0.0)
            self.register_variable(Real(f"command{index}", causality=Fmi2Causality.output))

    def exit_initialization_mode(self):
        """Initialise the filter with the reference."""
        self.filtered = self.speed_reference

    def do_step(self, current_time, step_size):
        """Compute the commands and the next state."""
        law = self.law
        level = np.array([np.interp(self.filtered, law["FORWARD"], law["PITCH"]), self.filtered, 0.0])
        measured = np.array([self.pitch, self.speed, self.pitch_rate])
        reference = np.array([self.pitch_reference, self.speed_reference, 0.0])
        y = (law["OF_REFERENCE"] @ reference + law["OF_MEASURED"] @ measured + law["OF_LEVEL"] @ level) / law[
            "SCALE"
        ]
        rho = (np.interp(self.speed, law["FORWARD"], law["SPEED"]) - law["CENTRE"]) / law["HALF"]
        rho = min(max(rho, -1.0), 1.0)
        z = np.linalg.solve(self.unit - law["Dtt"] * rho, law["Ct"] @ self.x + law["Dty"] @ y)
        w = rho * z
        u = law["Cu"] @ self.x + law["Duy"] @ y + law["Dut"] @ w
        self.x = law["A"] @ self.x + law["By"] @ y + law["Bt"] @ w
        for index, value in enumerate(u):
            scale, low, high = law["ACTUATOR"][index]
            trim = np.interp(self.filtered, law["FORWARD"], law["TRIM"][index])
            setattr(self, f"command{index}", float(min(max(trim + scale * value, low), high)))
        self.filtered += float(law["FILTER"]) * (self.speed_reference - self.filtered)
        return True
