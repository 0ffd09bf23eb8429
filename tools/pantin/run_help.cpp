#include "tools/pantin/run_help.hpp"

namespace pantin::program {

const char* const kRunFooter = R"(Examples:
  pantin run assets/scenes/chain.json
  pantin run assets/scenes/chain.json --frames out/chain --video out/chain.mp4 --size 1920x1080
  pantin run assets/scenes/marionette.json --gif out/marionette.gif --duration 4
  pantin run assets/scenes/marionette.json --strip out/marionette.png
  pantin run assets/scenes/four_bar.json --strip out/four_bar.png --from front
  pantin run assets/scenes/stack.json --strip out/stack.png --states
  pantin run assets/scenes/chain10.json --step 0.004166667 --record out/chain10.csv --json
  pantin run assets/scenes/crane.json --record out/crane.csv --columns '*.tension,*.angle' --digits 6
  pantin run assets/scenes/chain.json --record - --columns '*.x,*.y' --duration 1
  pantin run assets/scenes/crane.json --record out/crane.npz --columns '*.tension'
  pantin run assets/scenes/marionette.json --gltf out/marionette.glb --duration 4
  pantin run assets/scenes/lamp.json --record out/lamp.csv --columns '*.motor,bulb.*'
  pantin run assets/scenes/chain10.json --solver lagrangian --integrator rattle
  pantin run assets/scenes/chain10.json --solver lagrangian --tolerance 1e-8
  pantin run assets/scenes/wrecking_ball.json --set 'gravity=[0, -1.6, 0]'
  pantin run assets/scenes/marionette.json --save out/marionette.world
  pantin run assets/scenes/marionette.json --load out/marionette.world --strip out/later.png

Columns of --record, by --columns also those marked *: time_s; BODY.x y z qx qy qz qw vx vy vz wx wy
wz; BODY.contact_fx fy fz (N, sum of its contacts)* and .contacts (bodies touched; of a sensor:
overlapped)*; JOINT.gap_m; JOINT.angle (rad, whole turns counted), .second_angle (rad), .travel (m), .angular_speed, .speed (per
second)*; JOINT.motor (N m or N, of its motor or exact drive)*; JOINT.reaction_fx fy fz tx ty tz (N, N m about
its anchor, on body b, without springs and motors)*; CABLE.tension (N)*; PIN.pin_fx fy fz (N)*; SENSOR,
or SENSOR.x y z*; energies and momenta. An empty cell, in .npz NaN: no value. All in SI units, whatever
the units of the file.

--gltf writes a binary glTF 2.0 file for Blender, browsers and game engines: a node for each body, at the
frame of the columns x to qw, with its shapes; tubes along cables; one animation, at most 60 poses per
second.

--json prints one object: scene, title, status (ok, doubtful: there are findings, diverged,
inconsistent, contact_lost, energy_grew, aborted, interrupted, unwritable), solver ("mixed" if several), solvers (bodies of each),
step_s, substeps, steps, simulated_s, bodies, joints, cables, articulated_islands, worst_gap_m,
worst_gap_rel, energy_start_j, energy_end_j, energy_max_j, ns_per_link_step_median,
ns_per_link_step_p99, frame_ms_median, frame_ms_p99 (a step, without drawing),
allocations_per_step, hash, frames_written, cpu_ms_per_frame (all threads, start-up excluded),
worst_residual_m, sweeps_max, budget_ms, shortened_steps and given_up_max (substeps left out for
the budget, at most as a fraction of those of a group), left_out_max (islands that took no step
for the budget, at most), hurried_max (islands whose impacts were not followed within a step for the
budget, at most), limited_steps and energy_removed_j (by the energy limiter of auto),
rescued_steps (failed in the integrator, taken by
Euler's method), contacts (with force, at the end), contacts_max,
contact_depth_m (worst overlap after a step), limit_hits (joints at a limit, at the end),
limit_hits_max, limit_violation_rad, drives_capped_max,
final_acceleration_rms (m/s^2, mass centres, last second), unreached, lagrangian_islands
(of each: bodies, integrator, equations, rank, redundant, residual, substeps), findings (kind, where,
time_s, amount, unit, steps), energy_unchecked (bodies), sensors (their last values, by name), warnings, and lost after a divergence or a
growth of energy. engine/runtime/README.md describes each kind of finding.

Exit codes: 0 ok, 1 failed run, 2 usage or bad input, 3 diverged, energy grew or (--strict) findings, 4 could not write, 130 interrupted.)";

}  // namespace pantin::program
