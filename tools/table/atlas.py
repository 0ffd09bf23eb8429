"""The maps of the atlas: scene, axes, methods, and in one sentence why it fails there."""

TREES = ["auto", "shake2", "sweep", "procedural"]
EXACT = ["lagrangian/euler", "lagrangian/rattle", "lagrangian/rk4", "lagrangian/implicit", "lagrangian/radau"]
SHIPPED, OWN = "assets/scenes/", "assets/atlas/scenes/"
STEP, WIDE = "step=2e-3..0.1", "step=5e-3..0.5"

ENTRIES = [
    {"name": "mass_ratio", "title": "Mass ratio of links", "scene": SHIPPED + "heavy_tip.json",
     "over": [STEP, "/generators/chains/0/mass_ratio=1..1e3"], "duration": 2,
     "methods": TREES + ["lagrangian/euler", "lagrangian/rk4", "lagrangian/radau"],
     "mechanism": "Corrections of positions without the right masses throw light links about, and the integrators of lagrangian fall back on shorter or rescued steps where heavy ends snap light links straight, while auto holds everywhere but at the very corner."},
    {"name": "heavy_end", "title": "A heavy end", "scene": OWN + "ball_on_chain.json",
     "over": [STEP, "/bodies/ball/mass=0.01..1e4"], "duration": 2,
     "methods": TREES + ["lagrangian/euler", "lagrangian/rk4"],
     "mechanism": "A heavy end snaps the light chain straight within one step, which explicit corrections answer with energy and Euler's method with damping."},
    {"name": "thinness", "title": "Thin rods that whirl", "scene": OWN + "whirl.json",
     "over": [STEP, "/bodies/rod 0/inertia/1,/bodies/rod 1/inertia/1,/bodies/rod 2/inertia/1=1e-8..0.02"],
     "duration": 5, "methods": ["auto", "shake2", *EXACT],
     "mechanism": "The spin about a thin rod is fast and its inertia small, so that the corrections of shake2 excite it, while Euler's method damps the swing at every thinness."},
    {"name": "length", "title": "Length of a chain", "scene": SHIPPED + "chain10.json",
     "over": [STEP, "/generators/chains/0/links=2..100"], "duration": 1,
     "methods": [*TREES, "lagrangian/euler", "lagrangian/rattle", "lagrangian/rk4", "planar"],
     "mechanism": "Corrections that pass along the chain link by link gain energy with every link and step, while exact solves do not depend on the number of links."},
    {"name": "drag_speed", "title": "A chain dragged to and fro", "scene": OWN + "dragged.json",
     "over": [STEP, "/paths/0/lissajous/frequency/0=0.1..30"], "duration": 2,
     "methods": TREES + ["lagrangian/euler", "lagrangian/rk4"],
     "mechanism": "A support that reverses within a few steps does work that no method resolves, and the solvers that correct positions turn their corrections into speed."},
    {"name": "stiffness", "title": "Stiffness of a spring", "scene": OWN + "flap.json",
     "over": [STEP, "/joints/hinge/spring/stiffness=1..1e6"],
     "methods": ["auto", *EXACT, "planar"],
     "mechanism": "The boundaries are lines of constant frequency times step (stiffness as the inverse square of the step): beyond them rk4, radau, auto and planar damp the vibration, and the energy of rattle and implicit sways by its square; Euler's method damps it nearly everywhere."},
    {"name": "damping", "title": "A damper", "scene": OWN + "damped_flap.json",
     "over": [STEP, "/joints/hinge/spring/damping=1e-2..1e5"],
     "methods": ["auto", *EXACT, "planar"],
     "mechanism": "Explicit integrators cannot follow a decay faster than the step (the boundary is a line of constant damping times step) and are rescued by Euler's method, while implicit dampers are stable at any strength."},
    {"name": "vibration_damping", "title": "Numerical damping of the implicit integrator", "scene": OWN + "flap.json",
     "over": [STEP, "/solver/damping_ratio=0..1"], "duration": 2, "methods": ["lagrangian/implicit"],
     "mechanism": "The fraction of fast vibrations that is left after a step decides how much of the slow ones the implicit integrator takes."},
    {"name": "elastic_cable", "title": "Compliance of a cable", "scene": OWN + "cable.json",
     "over": [STEP, "/cables/0/compliance=1e-8..1"], "methods": ["auto", *EXACT],
     "mechanism": "A stiff cable becomes taut within a step, and its vibration is not resolved except by auto, which treats it implicitly."},
    {"name": "motor", "title": "Gain of a motor on a closed loop", "scene": SHIPPED + "four_bar.json",
     "over": [WIDE, "/joints/drive/motor/gain=0.1..1e5"], "duration": 2, "methods": [*EXACT, "planar"],
     "mechanism": "A gain times the step that exceeds the inertia is beyond explicit integrators, and limits the Newton iterations of the implicit ones."},
    {"name": "baumgarte", "title": "Baumgarte's feedback", "scene": OWN + "baumgarte.json",
     "over": [STEP, "/solver/baumgarte=0.1..1e3"],
     "methods": ["lagrangian/rattle", "lagrangian/rk4", "lagrangian/implicit"],
     "mechanism": "Too little feedback lets the joints of rk4 drift apart, the farther the longer the run (after 1 s in 6 % of the map, after 5 s in 18 %), and a rate times the step of 40 or more blows up; rattle and implicit close the joints by themselves and do not use it."},
    {"name": "singular_positions", "title": "Singular positions", "scene": OWN + "windows.json",
     "over": [WIDE, "/gravity/1=-1000..-1"], "methods": ["auto", "lagrangian/rk4", "lagrangian/radau", "planar"],
     "mechanism": "Where the links of a window lie in line the rows lose rank: at long steps the iterations of radau do not converge there, and planar gains or loses energy; with gravity upwards, so that the posts never lie down, radau holds everywhere."},
    {"name": "iterations", "title": "Sweeps over a chain held at both ends", "scene": SHIPPED + "pinned_chain.json",
     "over": [STEP, "/solver/sweeps=1..200"], "duration": 1, "methods": TREES,
     "mechanism": "Sweeps over a chain that both ends hold need more rounds than they are given, whereas auto solves for both ends at once."},
    {"name": "spin", "title": "Spin of a top", "scene": OWN + "top.json",
     "over": ["step=1e-4..0.05", "/bodies/top/angular_velocity/1=1..3000"],
     "methods": [*TREES, *EXACT],
     "mechanism": "Where the top turns by more than a quarter to a third of a turn in a step the corrections of shake2 gain energy, and below that they damp a quick spin, as Euler's method does; sweep and procedural gain or lose energy at nearly any rate."},
    {"name": "heavy_on_light", "title": "Heavy on light", "scene": OWN + "heavy_on_light.json",
     "over": [WIDE, "/bodies/heavy/mass=1..1e5"], "methods": ["auto", "lagrangian/euler", "lagrangian/rk4", "planar"],
     "mechanism": "The load of the heavy box is passed on by impulses that are found to a tolerance, so that at long steps and high ratios the light one is pressed into the floor."},
    {"name": "friction", "title": "Friction in a tower", "scene": OWN + "tower.json",
     "over": [WIDE, "/collision/friction=0..1"], "methods": ["auto", "lagrangian/euler", "planar"],
     "mechanism": "Planar impulses that are not iterated to the end let the tower sink into itself at long steps, and friction hardly matters."},
    {"name": "thin_wall", "title": "A whirling rod and a thin post", "scene": OWN + "whirling_rod.json",
     "over": ["/bodies/post/shape/size/1=1e-4..0.3", "/bodies/rod/angular_velocity/2=1..1e3"],
     "step": 1 / 60, "methods": ["auto", "lagrangian/euler", "lagrangian/rk4", "planar"],
     "mechanism": "A hinged rod that turns by more than a radian in a step skips thin posts at some speeds, and planar lets those thinner than half a millimetre through at most speeds; at a tenth of the step none is skipped."},
    {"name": "restitution", "title": "A ball that bounces", "scene": SHIPPED + "bounce.json",
     "over": [WIDE, "/collision/restitution=0..1"], "duration": 3,
     "methods": ["auto", "lagrangian/euler", "lagrangian/rk4", "planar"],
     "mechanism": "Only planar gains energy, at long steps and nearly elastic bounces, since the depth of a contact is removed by speed."},
    {"name": "curvature", "title": "A ball nearly as large as its cavity", "scene": OWN + "ball_in_cavity.json",
     "over": [WIDE, "/bodies/ball/shape/radius=0.2..0.498"],
     "methods": ["auto", "lagrangian/euler", "lagrangian/rk4"],
     "mechanism": "Two nearly equal curvatures leave the place of contact almost undetermined, and at long steps the ball sinks in there."},
    {"name": "quasistatic", "title": "Fingers and a rod, without inertia", "scene": OWN + "fingers.json",
     "over": ["/laminas/0/centre_of_mass/0=-0.59..0.59", "/laminas/0/fingers/0/velocity/0=1e-3..1"],
     "mechanism": "Forces of the fingers balance the weight only between them, and until they meet; beyond, dynamics takes over, so that the sides move with the points of the fingers, and the top with the time that they take."},
]


def words(entry):
    """The command line after the program's name, without the folder."""
    line = ["stability", entry["scene"]]
    for axis in entry["over"]:
        line += ["--over", axis]
    if entry.get("methods"):
        line += ["--methods", ",".join(entry["methods"])]
    for option in ("duration", "step"):
        if option in entry:
            line += [f"--{option}", str(entry[option])]
    return line
