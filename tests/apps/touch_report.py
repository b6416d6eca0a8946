"""What `proxima touch` says of a session, and what its simulated hand does."""
SCRIPTS = ("press", "slide", "stroke", "corner", "poke", "walk")
KEYS = ["model", "triangles", "device", "build_seconds", "units_per_metre", "center", "stiffness", "damping",
        "static_friction", "dynamic_friction", "radius", "shading", "force", "ticks", "touching_ticks", "sticking_ticks", "passes",
        "limited_ticks", "overloaded_ticks", "faulty_ticks", "moving_ticks", "squeezed_ticks", "max_force", "max_spring", "max_depth", "max_speed",
        "max_step_ratio", "max_turn_degrees", "taken_energy", "max_moves", "clamped_ticks", "slewed_ticks",
        "guard", "damped_ticks", "softened_ticks", "lowest_softness", "swings", "softenings", "most_damping", "longest_softening", "most_given", "texture", "texture_report", "tick", "servo", "replay_differences", "patches", "objects", "engine", "device_info", "hand", "input", "network",
        "button_events", "interrupted", "trouble"]
MEASURED = ("build_seconds", "tick", "servo")
OF_A_DEVICE = ("device_info", "hand", "input", "network", "button_events")
