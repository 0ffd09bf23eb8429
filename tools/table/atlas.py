"""The maps of the atlas: scene, axes, methods, and in one sentence why it fails there."""

TREES = ["auto", "shake2", "sweep", "procedural"]
EXACT = ["lagrangian/euler", "lagrangian/rattle", "lagrangian/rk4", "lagrangian/implicit", "lagrangian/radau"]
SHIPPED, OWN = "assets/scenes/", "assets/atlas/scenes/"
STEP, WIDE = "step=2e-3..0.1", "step=5e-3..0.5"

ENTRIES = [
    {"name": "mass_ratio", "title": "Mass ratio of links", "scene": SHIPPED + "heavy_tip.json",
     "over": [STEP, "/generators/chains/0/mass_ratio=1..1e3"], "duration": 2,
     "methods": TREES + ["lagrangian/euler", "lagrangian/rk4", "lagrangian/radau"],
     "mechanism": "Only shake2 fails for the ratio itself, where each link is heavier than the one above it and not where it is lighter, while sweep and procedural fail with equal links, too; the steps of rk4 and radau at high ratios are rescued even where the chain hangs nearly straight, and auto holds everywhere but at the very corner.",
     "experiment": "hung nearly straight, all 400 steps of rk4 are rescued, as many as when the chain swings; at a ratio of 1e-3 none is, and shake2 keeps the energy.",
     "shown_by": "run assets/scenes/heavy_tip.json --solver lagrangian --integrator rk4 --step 0.005 --duration 2 --set generators/chains/0/mass_ratio=1000 --set generators/chains/0/direction=[0.05,-1,0]"},
    {"name": "heavy_end", "title": "A heavy end", "scene": OWN + "ball_on_chain.json",
     "over": [STEP, "/bodies/ball/mass=0.01..1e4"], "duration": 2,
     "methods": TREES + ["lagrangian/euler", "lagrangian/rk4"],
     "mechanism": "Sweep gains energy at every mass of the ball, as procedural and shake2 do at long steps, and Euler's method damps nearly every one; only where the ball is much heavier than the chain shake2 gains energy at short steps, too, and rk4 is rescued, both even where the chain hangs nearly straight.",
     "experiment": "with a chain as heavy as the ball no step of rk4 is rescued (38 of 40 with the light chain), and shake2 loses energy instead at 5 ms; sweep gains as fast with a ball of 10 g.",
     "shown_by": "run assets/atlas/scenes/ball_on_chain.json --solver lagrangian --integrator rk4 --step 0.05 --duration 2 --set bodies/ball/mass=1e4 --set generators/chains/0/density=1e8"},
    {"name": "thinness", "title": "Thin rods that whirl", "scene": OWN + "whirl.json",
     "over": [STEP, "/bodies/rod 0/inertia/1,/bodies/rod 1/inertia/1,/bodies/rod 2/inertia/1=1e-8..0.02"],
     "duration": 5, "methods": ["auto", "shake2", *EXACT],
     "mechanism": "At short steps shake2 fails only where the rods spin, slowly if they are thin and fast at any thickness, and at long steps it fails without any spin; Euler's method damps the swing at every thinness.",
     "experiment": "without spin the energy of shake2 is the same at all thicknesses from 0.02 to 1e-7 kg m^2: kept at steps of 5 ms, lost at 30 ms.",
     "shown_by": "run assets/atlas/scenes/whirl.json --solver shake2 --step 0.03 --set 'bodies/rod 0/angular_velocity/1=0' --set 'bodies/rod 1/angular_velocity/1=0' --set 'bodies/rod 2/angular_velocity/1=0'"},
    {"name": "length", "title": "Length of a chain", "scene": SHIPPED + "chain10.json",
     "over": [STEP, "/generators/chains/0/links=2..100"], "duration": 1,
     "methods": [*TREES, "lagrangian/euler", "lagrangian/rattle", "lagrangian/rk4", "planar"],
     "mechanism": "Corrections that pass along the chain link by link gain the more energy the more links there are and, but for sweep, the longer the step is, while auto and rk4 keep it for any number of links, and rattle and planar at short steps.",
     "experiment": "shake2 keeps the energy of a hundred links at steps of 5 ms; at 20 ms it gains next to nothing with five links, 154 J with thirty, and 2.8 J with thirty that are 1 m together.",
     "shown_by": "run assets/scenes/chain10.json --solver shake2 --step 0.02 --duration 1 --set generators/chains/0/links=30"},
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
     "mechanism": "A chain that both ends hold tears where it is given too few sweeps, and one that one end holds needs a single sweep; the energy that is gained or lost hardly depends on their number, and auto solves for both ends at once.",
     "experiment": "at 50 ms sweep tears the joints with 16 sweeps and closes them with 200, and the energy after 1 s is 21.8 J with 16, 200 and 2000.",
     "shown_by": "run assets/scenes/pinned_chain.json --solver sweep --step 0.05 --duration 1 --set solver/sweeps=2000"},
    {"name": "spin", "title": "Spin of a top", "scene": OWN + "top.json",
     "over": ["step=1e-4..0.05", "/bodies/top/angular_velocity/1=1..3000"],
     "methods": [*TREES, *EXACT],
     "mechanism": "Where the top turns by more than a quarter to a third of a turn in a step the corrections of shake2 gain energy, and below that they damp a quick spin, as Euler's method does; sweep and procedural gain or lose energy at nearly any rate."},
    {"name": "heavy_on_light", "title": "Heavy on light", "scene": OWN + "heavy_on_light.json",
     "over": [WIDE, "/bodies/heavy/mass=1..1e5"], "methods": ["auto", "lagrangian/euler", "lagrangian/rk4", "planar"],
     "mechanism": "Planar impulses that are not iterated to the end press the light box into the floor at high ratios, euler and rk4 hold every ratio at steps shorter than a fall through the height of a box, and auto at all steps.",
     "experiment": "the step at which rk4 fails, 0.25 to 0.3 s, moves as the inverse root of gravity: beyond 0.5 s at a quarter of it, 0.1 to 0.2 s at four times; two boxes of 1e5 kg hold; 16 substeps reduce the depth under planar from 0.4 m to 3 mm.",
     "shown_by": "run assets/atlas/scenes/heavy_on_light.json --solver lagrangian --integrator rk4 --step 0.4 --set bodies/heavy/mass=1e4 --set gravity=[0,-2.4525,0]"},
    {"name": "friction", "title": "Friction in a tower", "scene": OWN + "tower.json",
     "over": [WIDE, "/collision/friction=0..1"], "methods": ["auto", "lagrangian/euler", "planar"],
     "mechanism": "Planar impulses that are not iterated to the end let a tower sink into itself by the square of the step, the more the higher it is, and friction hardly matters, except that a tower without any slides apart at long steps.",
     "experiment": "one box does not sink at 0.3 s, two sink by 0.5 mm and six by 36 mm, with friction of 0.5 and of 1 alike; four substeps leave 1.4 mm.",
     "shown_by": "run assets/atlas/scenes/tower.json --solver planar --step 0.3 --substeps 4"},
    {"name": "thin_wall", "title": "A whirling rod and a thin post", "scene": OWN + "whirling_rod.json",
     "over": ["/bodies/post/shape/size/1=1e-4..0.3", "/bodies/rod/angular_velocity/2=1..1e3"],
     "step": 1 / 60, "methods": ["auto", "lagrangian/euler", "lagrangian/rk4", "planar"],
     "mechanism": "A hinged rod that turns by more than a radian in a step skips thin posts at some speeds, and planar lets those thinner than half a millimetre through at most speeds; at a tenth of the step none is skipped."},
    {"name": "restitution", "title": "A ball that bounces", "scene": SHIPPED + "bounce.json",
     "over": [WIDE, "/collision/restitution=0..1"], "duration": 3,
     "methods": ["auto", "lagrangian/euler", "lagrangian/rk4", "planar"],
     "mechanism": "Only planar gains energy, at long steps and nearly elastic bounces, from gravity in the step of an impact.",
     "experiment": "without gravity a ball thrown at the floor keeps its energy to rounding at steps from 5 ms to 0.5 s, and elastic bounces of planar, with gravity or without, have no depth that could be turned into speed.",
     "shown_by": "run assets/scenes/bounce.json --solver planar --step 0.2 --duration 3 --set gravity=[0,0,0] --set bodies/ball/velocity=[0,-4,0]"},
    {"name": "curvature", "title": "A ball nearly as large as its cavity", "scene": OWN + "ball_in_cavity.json",
     "over": [WIDE, "/bodies/ball/shape/radius=0.2..0.498"],
     "methods": ["auto", "lagrangian/euler", "lagrangian/rk4"],
     "mechanism": "A ball that starts beside the centre of its cavity has its nearest place at the side, and in a step that is long enough for the fall it passes the bottom unseen, whether the two curvatures are nearly equal or not.",
     "experiment": "from 1.5 mm below the centre the largest ball sinks by 0 to 9 mm at 0.4 s instead of 0.38 m, and a ball of 0.2 m, which is far from equal, sinks by 0.09 m from the centre and not at all from 0.1 m below it.",
     "shown_by": "run assets/atlas/scenes/ball_in_cavity.json --step 0.4 --set bodies/ball/shape/radius=0.498 --set bodies/ball/velocity=[0,0,0] --set bodies/ball/position=[0.001,-0.0015,0]"},
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
