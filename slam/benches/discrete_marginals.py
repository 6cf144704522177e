"""Writes what slam/tests/association/discrete_marginals.rs compares with: marginals of associations by GTSAM's DiscreteMarginals.

discrete_marginals.py > slam/tests/association/discrete_marginals.txt

A robot moves in a plane without heading and sees two landmarks of known priors. Each detection is of one of them, or false. Needs gtsam 4.3.0.
"""

import math
import random

import gtsam
import numpy as np
from gtsam import symbol

MOTION, DETECTION, SPREAD, START, FALSE = 0.3, 0.2, 1.0, 0.1, 0.05
LANDMARKS = 2
UNIT = gtsam.noiseModel.Unit.Create(2)


def density(deviation):
    return -math.log(2 * math.pi * deviation**2)


def factor(keys, signs, measured, deviation):
    blocks = [sign * np.eye(2) / deviation for sign in signs]
    return jacobian(keys, blocks, np.asarray(measured) / deviation)


def jacobian(keys, blocks, right):
    terms = [item for pair in zip(keys, blocks) for item in pair]
    return gtsam.JacobianFactor(*terms, right, UNIT)


def marginals(motions, seen):
    graph = gtsam.HybridGaussianFactorGraph()
    places = [symbol("l", i) for i in range(LANDMARKS)]
    for i, place in enumerate(places):
        graph.push_back(factor([place], [1.0], [1.0 - 2.0 * i, 0.5], SPREAD))
    graph.push_back(factor([symbol("x", 0)], [1.0], [0.0, 0.0], START))
    names = []
    for step, (motion, detections) in enumerate(zip(motions, seen)):
        robot = symbol("x", step)
        if step > 0:
            graph.push_back(factor([symbol("x", step - 1), robot], [-1.0, 1.0], motion, MOTION))
        for detection in detections:
            name = (symbol("d", len(names)), LANDMARKS + 1)
            names.append(name)
            ways = []
            for i in range(LANDMARKS + 1):
                # Components have the same variables: what is not meant has no weight.
                blocks = [-np.eye(2) / DETECTION if i < LANDMARKS else np.zeros((2, 2))]
                blocks += [np.eye(2) / DETECTION if i == j else np.zeros((2, 2)) for j in range(LANDMARKS)]
                right = np.asarray(detection) / DETECTION if i < LANDMARKS else np.zeros(2)
                log = density(DETECTION) if i < LANDMARKS else math.log(FALSE)
                # A scalar is an energy: what is added to half the squared error.
                ways.append((jacobian([robot, *places], blocks, right), -log))
            graph.push_back(gtsam.HybridGaussianFactor(name, ways))
    ordering = gtsam.Ordering()
    for step in range(len(motions)):
        ordering.push_back(symbol("x", step))
    for place in places:
        ordering.push_back(place)
    for name, _ in names:
        ordering.push_back(name)
    net = graph.eliminateSequential(ordering)
    discrete = gtsam.DiscreteFactorGraph()
    posterior = net.discreteMarginal()
    for i in range(posterior.size()):
        conditional = posterior.at(i)
        if isinstance(conditional, gtsam.TableDistribution):
            # The last one left, which the marginals take as a tree alone.
            values = [value for _, value in conditional.enumerate()]
            discrete.push_back(gtsam.DecisionTreeFactor([names[-1]], values))
        else:
            discrete.push_back(conditional)
    found = gtsam.DiscreteMarginals(discrete)
    return [found.marginalProbabilities(name) for name in names]


for seed in range(3):
    random.seed(seed)

    def draw(scale):
        return [round(random.gauss(0.0, scale), 3), round(random.gauss(0.0, scale), 3)]

    motions = [draw(0.5) for _ in range(4)]
    landmarks = [[1.0, 0.5], [-1.0, 0.5]]
    seen = []
    for step in range(4):
        at = draw(0.6)
        count = 2 if step % 2 == 0 else 1
        seen.append([[round(a + b, 3) for a, b in zip(landmarks[(i + step) % 2], draw(0.7))] for i in range(count)])
    print("world")
    for motion, detections in zip(motions, seen):
        print("motion", *motion)
        for detection in detections:
            print("seen", *detection)
    for probabilities in marginals(motions, seen):
        print("marginal", *(f"{p:.15e}" for p in probabilities))
