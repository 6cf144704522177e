"""Runs solvers of GTSAM on shuffled measurements of MH-iSAM2; see association.sh.

association.py SOLVER victoria FILE    FILE as `association shuffled` writes it
association.py SOLVER city FILE        every loop may be false

SOLVER is one of:
smoother       HybridSmoother. After each choice it is updated and linearised anew, which is what makes it right; its upstream example does so more
               rarely. It keeps 10 hypotheses, as there, and fixes modes of a probability of .99.
alternation    DCSAM. After each choice it is updated: discrete and continuous variables by turns, once each.

Start values come from the first mode of the shuffled file. Candidates of a landmark join all candidates, with zero derivatives for those that are
not meant, since components must have the same keys.
"""

import statistics
import sys
import time

import gtsam
import numpy as np
from gtsam import noiseModel, symbol

LEAVES, FIXED = 10, 0.99
VICTORIA = noiseModel.Diagonal.Sigmas(np.array([0.01, 0.002, 0.002]))
POINT = noiseModel.Diagonal.Sigmas(np.array([0.4**0.5] * 2))
CITY = noiseModel.Diagonal.Sigmas(np.array([1 / 30, 1 / 30, 1 / 100]))
# Of the same density as a motion that is uniform within 3 m.
NULL = noiseModel.Diagonal.Sigmas(np.array([10.0] * 3))
START = noiseModel.Diagonal.Sigmas(np.array([1e-3] * 3))


def lines(path):
    """Kind, pose, candidates, whether it may be false, modes, and where the true candidate and mode stand."""
    for text in open(path):
        words = text.split()
        kind, pose, count = words[0], int(words[1]), int(words[2])
        candidates = [int(word) for word in words[3 : 3 + count]]
        rest = words[3 + count :]
        modes, numbers = int(rest[1]), rest[2:-2]
        values = np.array(numbers, dtype=float).reshape(modes, -1)
        yield kind, pose, candidates, rest[0] == "1", values, int(rest[-2]), int(rest[-1])


def seen(robot, points, meant, measured):
    """A factor of one of several points in the robot's frame."""

    def error(this, values, jacobians):
        pose, point = values.atPose2(robot), values.atPoint2(points[meant])
        by_pose, by_point = np.zeros((2, 3), order="F"), np.zeros((2, 2), order="F")
        there = pose.transformTo(point, by_pose, by_point)
        if jacobians is not None:
            jacobians[0] = by_pose
            for i in range(len(points)):
                jacobians[i + 1] = by_point if i == meant else np.zeros((2, 2), order="F")
        return there - measured

    return gtsam.CustomFactor(POINT, [robot, *points], error)


def polar(robot, point, measured):
    """A factor of one point of GTSAM's own, by bearing and range: one in Python is slow. Its noise is that of the place, turned."""
    distance, deviation = np.hypot(*measured), 0.4**0.5
    model = noiseModel.Diagonal.Sigmas(np.array([deviation / distance, deviation]))
    bearing = gtsam.Rot2.atan2(measured[1], measured[0])
    return gtsam.BearingRangeFactor2D(robot, point, bearing, distance, model)


class Smoother:
    """HybridSmoother."""

    def __init__(self):
        self.smoother = gtsam.HybridSmoother(FIXED)
        self.values = gtsam.Values()

    def update(self, graph, values):
        self.values.insert(values)
        self.smoother.update(graph, self.values, LEAVES)
        self.smoother.relinearize()
        self.values = self.smoother.linearizationPoint()

    def discrete(self):
        return self.smoother.optimize().discrete()


class Alternation:
    """DCSAM."""

    def __init__(self):
        self.dcsam = gtsam.DCSAM()
        self.values = gtsam.Values()

    def update(self, graph, values):
        self.dcsam.update(graph, gtsam.HybridValues(gtsam.VectorValues(), gtsam.DiscreteValues(), values))
        self.values = self.dcsam.calculateEstimate().nonlinear()

    def discrete(self):
        return self.dcsam.calculateEstimate().discrete()


class Run:
    def __init__(self, solver):
        self.solver = solver
        self.graph, self.fresh = gtsam.HybridNonlinearFactorGraph(), gtsam.Values()
        self.fresh.insert(symbol("x", 0), gtsam.Pose2())
        self.graph.push_back(gtsam.PriorFactorPose2(symbol("x", 0), gtsam.Pose2(), START))
        self.truth, self.seconds, self.start = [], [], time.process_time()

    def pose(self, number):
        key = symbol("x", number)
        return (self.fresh if self.fresh.exists(key) else self.solver.values).atPose2(key)

    def choose(self, components, truth):
        key = (symbol("m", len(self.truth)), len(components))
        weighed = [(factor, factor.noiseModel().negLogConstant()) for factor in components]
        self.graph.push_back(gtsam.HybridNonlinearFactor(key, weighed))
        self.truth.append(truth)
        start = time.process_time()
        self.update()
        self.seconds.append(time.process_time() - start)

    def update(self):
        self.solver.update(self.graph, self.fresh)
        self.graph, self.fresh = gtsam.HybridNonlinearFactorGraph(), gtsam.Values()

    def finish(self):
        self.update()
        answer = self.solver.discrete()
        wrong = [i for i, truth in enumerate(self.truth) if answer[symbol("m", i)] != truth]
        times = sorted(1e3 * second for second in self.seconds)
        print(f"choices {len(self.truth)}\nwrong {len(wrong)} {wrong}\ncpu {time.process_time() - self.start:.2f}")
        print(f"ms p50 {statistics.median(times):.2f}\nms p95 {times[int(0.95 * len(times))]:.2f}\nms max {times[-1]:.2f}")


def victoria(solver, path):
    run, known = Run(solver), set()
    for kind, pose, candidates, _, values, candidate, _ in lines(path):
        robot = symbol("x", pose)
        if kind == "POSE":
            motion = gtsam.Pose2(*values[0])
            run.graph.push_back(gtsam.BetweenFactorPose2(robot, symbol("x", candidates[0]), motion, VICTORIA))
            run.fresh.insert(symbol("x", candidates[0]), run.pose(pose).compose(motion))
            continue
        points = [symbol("l", landmark) for landmark in candidates]
        if len(candidates) == 1 and candidates[0] not in known:
            known.add(candidates[0])
            run.fresh.insert(points[0], run.pose(pose).transformFrom(values[0]))
        if len(points) == 1:
            run.graph.push_back(polar(robot, points[0], values[0]))
        else:
            run.choose([seen(robot, points, i, values[0]) for i in range(len(points))], candidate)
    run.finish()


def city(solver, path):
    run = Run(solver)
    for _, pose, candidates, _, values, _, mode in lines(path):
        ends = symbol("x", pose), symbol("x", candidates[0])
        motions = [gtsam.Pose2(*value) for value in values]
        factors = [gtsam.BetweenFactorPose2(*ends, motion, CITY) for motion in motions]
        if abs(pose - candidates[0]) == 1:
            run.fresh.insert(ends[1], run.pose(pose).compose(motions[0]))
            if len(factors) == 1:
                run.graph.push_back(factors[0])
            else:
                run.choose(factors, mode)
        else:
            run.choose([*factors, gtsam.BetweenFactorPose2(*ends, motions[0], NULL)], mode)
    run.finish()


if __name__ == "__main__":
    solver, case, path = sys.argv[1:]
    solver = {"smoother": Smoother, "alternation": Alternation}[solver]()
    {"victoria": victoria, "city": city}[case](solver, path)
