"""The motion of a scene in Exudyn: redundant coordinates, implicit integrators.

usage: exudyn_motion.py SPELT OUT METHOD 0     generalized-alpha, trapezoidal
"""
import sys
import time

import exudyn
import exudyn.utilities as made
import numpy

import spelt


def matrix(q):
    return numpy.array([spelt.rotated(q, axis) for axis in ([1, 0, 0], [0, 1, 0], [0, 0, 1])]).T


def main():
    if len(sys.argv) != 5 or sys.argv[3] not in ("generalized-alpha", "trapezoidal"):
        sys.exit(__doc__)
    scene = spelt.Scene(sys.argv[1])
    if scene.sway:
        sys.exit("exudyn_motion.py: found a body on a path, which would be a function in Python")
    mbs = exudyn.SystemContainer().AddSystem()
    ground = mbs.CreateGround()
    bodies = [mbs.CreateRigidBody(
        referencePosition=b.position, referenceRotationMatrix=matrix(b.rotation), gravity=scene.gravity,
        inertia=made.RigidBodyInertia(mass=b.mass, inertiaTensor=numpy.diag(b.inertia)))
        for b in scene.bodies]
    for j in scene.joints:
        pair = [bodies[i] if i >= 0 else ground for i in (j.a, j.b)]
        if j.is_hinge:
            mbs.CreateRevoluteJoint(bodyNumbers=pair, position=j.anchor, axis=j.axis, useGlobalFrame=True)
        else:
            mbs.CreateSphericalJoint(bodyNumbers=pair, position=j.anchor, useGlobalFrame=True)
    for s in scene.springs:
        mbs.CreateSpringDamper(bodyNumbers=[bodies[i] if i >= 0 else ground for i in (s.a, s.b)],
                               localPosition0=s.anchor_a, localPosition1=s.anchor_b,
                               referenceLength=s.length, stiffness=s.stiffness, damping=0)
    for body, torque in scene.torques:
        mbs.CreateTorque(bodyNumber=bodies[body], loadVector=torque)
    sensors = [mbs.AddSensor(made.SensorBody(bodyNumber=b, storeInternal=True,
                                             outputVariableType=exudyn.OutputVariableType.Position))
               for b in bodies]
    mbs.Assemble()
    s = exudyn.SimulationSettings()
    s.timeIntegration.numberOfSteps = scene.frames * scene.parts
    s.timeIntegration.endTime = scene.frames / scene.rate
    s.timeIntegration.newton.useModifiedNewton = True
    s.timeIntegration.newton.relativeTolerance = 1e-10
    s.timeIntegration.verboseMode = 0
    s.solutionSettings.writeSolutionToFile = False
    s.solutionSettings.sensorsWritePeriod = 1 / scene.rate
    s.parallel.numberOfThreads = 1
    solver = exudyn.DynamicSolverType.TrapezoidalIndex2
    if sys.argv[3] == "generalized-alpha":
        solver = exudyn.DynamicSolverType.GeneralizedAlpha
        s.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    words = "double, rho 0.9, modified Newton"
    if len(scene.joints) > len(scene.bodies):  # loops, of which some rows depend on others
        s.linearSolverType = exudyn.LinearSolverType.EigenDense
        s.linearSolverSettings.ignoreSingularJacobian = True
        words += ", full-pivot LU that skips dependent rows"
    elif len(scene.bodies) > 4:
        s.linearSolverType = exudyn.LinearSolverType.EigenSparse
    begin = time.process_time()
    try:
        done = mbs.SolveDynamic(s, solverType=solver)
    except Exception:  # the solver gives up by an exception
        done = False
    ms = 1e3 * (time.process_time() - begin) / scene.frames
    tracks = [mbs.GetSensorStoredData(sensor) for sensor in sensors] if done else []
    frames = ((ms, [[float(x) for x in track[i][1:4]] for track in tracks])
              for i in range(1, scene.frames + 1 if done else 1))
    spelt.write_motion(sys.argv[2], [("version", exudyn.__version__), ("settings", words)], frames)


if __name__ == "__main__":
    main()
