"""The main job (`run.py fly`) and the tests (`run.py test`) as sequences of stages.

main_job   build -> environment -> design and package -> flight
flight     validate -> couple -> simulate -> compare -> plot -> figures   (in the environment with FMPy)
all_tests  format -> lints -> Rust -> documentation, in parallel with the main job of each vehicle -> Python
"""
