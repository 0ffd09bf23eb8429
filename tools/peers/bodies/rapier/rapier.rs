// A scene in Rapier, as its guide shows it: one step of 1/60 s a frame on one thread, impulse
// joints, settings as they come, masses and inertias those of the scene.
//
// usage: peers_rapier SPELT OUT ITERATIONS     of the solver in a step; 0: those it comes with
use rapier3d::prelude::*;
use std::io::Write;

/// The numbers of a line, one after the other.
struct Words<'a>(std::str::SplitWhitespace<'a>);

impl<'a> Words<'a> {
    fn text(&mut self) -> &'a str {
        self.0.next().expect("a word is missing")
    }
    fn one(&mut self) -> f32 {
        self.text().parse().expect("expected a number")
    }
    fn whole(&mut self) -> i32 {
        self.text().parse().expect("expected a whole number")
    }
    fn vector(&mut self) -> Vector {
        Vector::new(self.one(), self.one(), self.one())
    }
    fn rotation(&mut self) -> Rotation {
        Rotation::from_xyzw(self.one(), self.one(), self.one(), self.one()).normalize()
    }
    fn pose(&mut self) -> Pose {
        let at = self.vector();
        Pose::from_parts(at, self.rotation())
    }
    fn range(&mut self) -> Option<[f32; 2]> {
        let on = self.whole() != 0;
        let limits = [self.one(), self.one()];
        on.then_some(limits)
    }
    fn has_more(&self) -> bool {
        self.0.clone().next().is_some()
    }
}

struct Drive {
    joint: ImpulseJointHandle,
    axes: Vec<JointAxis>,
    stiffness: f32,
    damping: f32,
    targets: Vec<Rotation>,
}

struct Spring {
    bodies: [i32; 2],
    anchors: [Vector; 2],
    length: f32,
    stiffness: f32,
}

struct Scene {
    world: PhysicsWorld,
    frames: usize,
    rate: usize,  // frames of a second
    parts: usize, // steps of a frame
    touch: Vec<u32>,
    bodies: Vec<RigidBodyHandle>,
    still: RigidBodyHandle, // what stands for the world where a joint holds to it
    joints: Vec<ImpulseJointHandle>,
    kinds: Vec<String>,
    friction: f32,
    restitution: f32,
    layer: i32,
    drives: Vec<Drive>,
    paths: Vec<(RigidBodyHandle, Vec<Pose>)>,
    springs: Vec<Spring>,
    torques: Vec<(RigidBodyHandle, Vector)>, // constant, in the world's axes
    without: Vec<String>,
}

impl Scene {
    /// What write_plain() of plain.hpp writes; the words are told there.
    fn read(text: &str) -> Scene {
        let mut world = PhysicsWorld::new();
        let still = world.insert_body(RigidBodyBuilder::fixed());
        let mut scene = Scene {
            world, frames: 0, rate: 60, parts: 1, touch: vec![], bodies: vec![], still, joints: vec![], kinds: vec![],
            friction: 0.0, restitution: 0.0, layer: -1, drives: vec![], paths: vec![], springs: vec![],
            torques: vec![],
            without: vec![],
        };
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            let mut words = Words(line.split_whitespace());
            match words.text() {
                "gravity" => scene.world.gravity = words.vector(),
                "frames" => scene.frames = words.whole() as usize,
                "rate" => scene.rate = words.whole() as usize,
                "parts" => scene.parts = words.whole() as usize,
                "layers" => {
                    let count = words.whole() as usize;
                    assert!(count <= 32, "more than the 32 layers that Rapier has bits for");
                    for _ in 0..count {
                        let row = lines.next().expect("a layer is missing").split_whitespace();
                        let bits = row.enumerate().map(|(i, w)| ((w == "1") as u32) << i);
                        scene.touch.push(bits.sum());
                    }
                }
                "body" => scene.read_body(&mut words),
                "shape" => scene.read_shape(&mut words),
                "joint" => scene.read_joint(&mut words),
                "drive" => scene.read_drive(&mut words),
                "cable" => scene.read_cable(&mut words),
                "spring" => scene.springs.push(Spring {
                    bodies: [words.whole(), words.whole()],
                    anchors: [words.vector(), words.vector()],
                    length: words.one(),
                    stiffness: words.one(),
                }),
                "torque" => {
                    let body = scene.bodies[words.whole() as usize];
                    scene.torques.push((body, words.vector()));
                }
                "path" => {
                    let body = scene.bodies[words.whole() as usize];
                    let mut poses = vec![];
                    while words.has_more() {
                        poses.push(words.pose());
                    }
                    scene.paths.push((body, poses));
                }
                "unknown" => scene.without.push(line[8..].to_string()),
                word => panic!("'{word}' is no word of a scene"),
            }
        }
        scene
    }

    fn read_body(&mut self, words: &mut Words) {
        words.text();
        let motion = words.text();
        self.layer = words.whole();
        let (mass, inertia, pose) = (words.one(), words.vector(), words.pose());
        let (velocity, spin) = (words.vector(), words.vector());
        let (drag, gravity) = (words.one(), words.one());
        self.friction = words.one();
        self.restitution = words.one();
        let body = match motion {
            "dynamic" => RigidBodyBuilder::dynamic(),
            "fixed" => RigidBodyBuilder::fixed(),
            _ => RigidBodyBuilder::kinematic_position_based(),
        };
        let body = body
            .pose(pose)
            .linvel(velocity)
            .angvel(spin)
            .linear_damping(drag)
            .angular_damping(drag)
            .gravity_scale(gravity)
            .additional_mass_properties(MassProperties::new(Vector::ZERO, mass, inertia));
        self.bodies.push(self.world.insert_body(body));
    }

    fn read_shape(&mut self, words: &mut Words) {
        let kind = words.text();
        let (size, pose) = (words.vector(), words.pose());
        let collider = match kind {
            "sphere" => ColliderBuilder::ball(size.x),
            "capsule" => ColliderBuilder::capsule_y(size.y, size.x),
            "cylinder" => ColliderBuilder::cylinder(size.y, size.x),
            "box" => ColliderBuilder::cuboid(size.x, size.y, size.z),
            "plane" => ColliderBuilder::new(SharedShape::halfspace(Vector::Y)),
            _ => {
                let mut points = vec![];
                while words.has_more() {
                    points.push(words.vector());
                }
                ColliderBuilder::convex_hull(&points).expect("no hull")
            }
        };
        if self.layer < 0 {
            return;
        }
        let layer = self.layer as usize;
        let groups = InteractionGroups::new(
            Group::from_bits_truncate(1 << layer),
            Group::from_bits_truncate(self.touch[layer]),
            InteractionTestMode::And,
        );
        let collider = collider
            .position(pose)
            .density(0.0)
            .friction(self.friction)
            .friction_combine_rule(CoefficientCombineRule::GeometricMean)
            .restitution(self.restitution)
            .restitution_combine_rule(CoefficientCombineRule::Max)
            .collision_groups(groups);
        let body = *self.bodies.last().expect("a shape before any body");
        self.world.insert_collider(collider, Some(body));
    }

    fn body(&self, number: i32) -> RigidBodyHandle {
        if number < 0 { self.still } else { self.bodies[number as usize] }
    }

    fn read_joint(&mut self, words: &mut Words) {
        let kind = words.text();
        let (a, b) = (words.whole(), words.whole());
        let (anchor_a, anchor_b) = (words.vector(), words.vector());
        let (axes_a, axes_b) = (words.rotation(), words.rotation());
        let (first, second, swing) = (words.range(), words.range(), words.range());
        let locked = match kind {
            "hinge" => JointAxesMask::LOCKED_REVOLUTE_AXES,
            "universal" => JointAxesMask::LOCKED_SPHERICAL_AXES | JointAxesMask::ANG_X,
            "fixed" => JointAxesMask::LOCKED_FIXED_AXES,
            _ => JointAxesMask::LOCKED_SPHERICAL_AXES,
        };
        let mut joint = GenericJointBuilder::new(locked)
            .local_frame1(Pose::from_parts(anchor_a, axes_a))
            .local_frame2(Pose::from_parts(anchor_b, axes_b))
            .contacts_enabled(false);
        let mut limit = |axis, range: Option<[f32; 2]>| {
            if let Some(range) = range {
                joint = joint.clone().limits(axis, range);
            }
        };
        match kind {
            "hinge" => limit(JointAxis::AngX, first),
            "universal" => {
                limit(JointAxis::AngY, first);
                limit(JointAxis::AngZ, second);
            }
            _ => {
                limit(JointAxis::AngX, first);
                limit(JointAxis::AngY, swing.map(|half| [-half[0], half[0]]));
                limit(JointAxis::AngZ, swing.map(|half| [-half[1], half[1]]));
            }
        }
        let (a, b) = (self.body(a), self.body(b));
        self.joints.push(self.world.insert_impulse_joint(a, b, joint.build()));
        self.kinds.push(kind.to_string());
    }

    fn read_drive(&mut self, words: &mut Words) {
        let number = words.whole() as usize;
        let (stiffness, damping, most) = (words.one(), words.one(), words.one());
        let targets = (0..words.whole()).map(|_| words.rotation()).collect();
        if self.kinds[number] != "hinge" {
            return self.without.push("drives of joints that are no hinges".to_string());
        }
        let joint = self.joints[number];
        let data = &mut self.world.impulse_joints.get_mut(joint, true).expect("a joint").data;
        data.set_motor_model(JointAxis::AngX, MotorModel::ForceBased);
        data.set_motor_max_force(JointAxis::AngX, most);
        self.drives.push(Drive { joint, axes: vec![JointAxis::AngX], stiffness, damping, targets });
    }

    fn read_cable(&mut self, words: &mut Words) {
        let (a, b) = (words.whole(), words.whole());
        let (anchor_a, anchor_b) = (words.vector(), words.vector());
        let rope = RopeJointBuilder::new(words.one()).local_anchor1(anchor_a).local_anchor2(anchor_b);
        if words.one() > 0.0 {
            self.without.push("compliance of cables".to_string());
        }
        let (a, b) = (self.body(a), self.body(b));
        self.world.insert_impulse_joint(a, b, rope.build());
    }

    /// Loads the bodies with what springs and torques come to now.
    fn push(&mut self) {
        if self.springs.is_empty() && self.torques.is_empty() {
            return;
        }
        for handle in &self.bodies {
            let body = &mut self.world.bodies[*handle];
            body.reset_forces(true);
            body.reset_torques(true);
        }
        for spring in &self.springs {
            let handles = spring.bodies.map(|number| self.body(number));
            let ends = [0, 1].map(|i| {
                self.world.bodies[handles[i]].position().transform_point(spring.anchors[i])
            });
            let along = ends[1] - ends[0];
            let pull = along * (spring.stiffness * (1.0 - spring.length / along.length()));
            self.world.bodies[handles[0]].add_force_at_point(pull, ends[0], true);
            self.world.bodies[handles[1]].add_force_at_point(-pull, ends[1], true);
        }
        for (body, torque) in &self.torques {
            self.world.bodies[*body].add_torque(*torque, true);
        }
    }

    fn step(&mut self, part: usize) {
        self.push();
        for (body, poses) in &self.paths {
            if let Some(pose) = poses.get(part) {
                self.world.bodies[*body].set_next_kinematic_position(*pose);
            }
        }
        for drive in &self.drives {
            let q = drive.targets[part.min(drive.targets.len() - 1)];
            let angle = 2.0 * q.x.atan2(q.w);
            let angle = angle - (angle / std::f32::consts::TAU).round() * std::f32::consts::TAU;
            let joint = self.world.impulse_joints.get_mut(drive.joint, true).expect("a joint");
            for axis in &drive.axes {
                joint.data.set_motor_position(*axis, angle, drive.stiffness, drive.damping);
            }
        }
        self.world.step();
    }

    /// Of each body: place, rotation, velocity and spin; and how many are awake.
    fn state(&self) -> (f64, Vec<f64>) {
        let mut numbers = vec![];
        let mut awake = 0;
        for handle in &self.bodies {
            let body = &self.world.bodies[*handle];
            let (x, q) = (body.position().translation, body.position().rotation);
            let (v, w) = (body.linvel(), body.angvel());
            numbers.extend([x.x, x.y, x.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z]);
            awake += (body.is_dynamic() && !body.is_sleeping()) as i32;
        }
        (awake as f64, numbers.iter().map(|n: &f32| *n as f64).collect())
    }
}

/// CPU time of this process, ms.
fn cpu_ms() -> f64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut now) };
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

fn main() -> std::io::Result<()> {
    let words: Vec<String> = std::env::args().collect();
    if words.len() != 4 {
        eprintln!("usage: peers_rapier SPELT OUT ITERATIONS");
        std::process::exit(2);
    }
    let mut scene = Scene::read(&std::fs::read_to_string(&words[1])?);
    let iterations: usize = words[3].parse().unwrap_or(0);
    if iterations > 0 {
        scene.world.integration_parameters.num_solver_iterations = iterations;
    }
    scene.world.integration_parameters.dt =
        1.0 / (scene.rate * scene.parts) as f32;
    let mut out = std::io::BufWriter::new(std::fs::File::create(&words[2])?);
    writeln!(out, "engine rapier\nversion 0.36.1\nbuilt opt-level 3")?;
    writeln!(
        out,
        "settings defaults ({} solver iterations), impulse joints, {} steps a frame, 1 thread",
        scene.world.integration_parameters.num_solver_iterations, scene.parts
    )?;
    scene.without.sort();
    scene.without.dedup();
    for what in &scene.without {
        writeln!(out, "without {what}")?;
    }
    writeln!(out, "frames {}", scene.bodies.len())?;
    for frame in 0..scene.frames {
        let before = cpu_ms();
        for part in 0..scene.parts {
            scene.step(frame * scene.parts + part);
        }
        let ms = cpu_ms() - before;
        let (awake, numbers) = scene.state();
        for number in [ms, awake].iter().chain(&numbers) {
            out.write_all(&number.to_ne_bytes())?;
        }
    }
    out.flush()
}
