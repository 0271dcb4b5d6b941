"""The main job and the tests as a sequence of stages; `run.py` at the top of the repository is the way in.

main_job   build -> environment -> design and package -> flight
flight     validate -> couple -> simulate -> compare -> plot -> figures   (inside the environment, with FMPy)
all_tests  format -> lints -> Rust -> documentation, and at the same time main job of each vehicle -> Python
"""
