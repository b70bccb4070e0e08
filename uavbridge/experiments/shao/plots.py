"""The pictures of the Shao experiments."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps

from uavbridge.experiments.experiment import Case, Outcome
from uavbridge.experiments.style import FAINT, GREEN, INDIGO, INK, ORANGE, PURPLE, RED, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PRINTED_ALL_FOUND = 185
PRINTED_RESPONSE = (20.0, 80.0)


def detection(figure: Figure, outcome: Outcome) -> None:
    """Figs 4-6: acquisition, coverage beside fixed routes, responses; and the sweeps."""
    figure.set_size_inches(11.5, 6.8)
    acquired, covered, first, response, share, recovery = figure.subplots(2, 3).flat
    teams = [case for case, _ in outcome.samples if set(case) == {"n_uav"}]
    shades = colormaps["viridis"](np.linspace(0.0, 0.9, max(len(teams), 2)))
    for case, colour in zip(teams, shades, strict=False):
        label = f"{case['n_uav']} UAVs"
        _curve(acquired, outcome, case, "acquired@step", color=colour, label=label)
        _curve(covered, outcome, case, "covered@step", color=colour)
    _routes(covered, outcome)
    acquired.set_title("targets found", loc="left", color=INK)
    covered.set_title("coverage, fixed routes dashed", loc="left", color=INK)
    for axes in (acquired, covered):
        axes.set_xlabel("step")
        axes.set_xlim(0, outcome.params.steps / 3)
    acquired.legend(frameon=False, fontsize=7)
    covered.legend(frameon=False, fontsize=7, loc="lower right")
    _over(first, outcome, "n_uav", "steps_all_found", INDIGO)
    first.set_yscale("log")
    first.set_title("steps until all are found", loc="left", color=INK)
    _over(response, outcome, "n_uav", "revisit_response", GREEN)
    response.set_title("steps to answer a revisit signal", loc="left", color=INK)
    if outcome.params.size == 50:
        first.axhline(PRINTED_ALL_FOUND, color=INK, lw=1.0, ls=":")
        response.axhspan(*PRINTED_RESPONSE, color=FAINT, alpha=0.25, lw=0)
    _swept(share, outcome, "random_share", "share of the random group")
    _swept(recovery, outcome, "recovery", "recovery of path pheromone a step")
    for axes in figure.axes:
        plain(axes)


def _curve(axes: Axes, outcome: Outcome, case: Case, metric: str, **style: object) -> None:
    values = outcome.of(**case)[metric]
    axis = outcome.experiment.axis
    assert axis is not None
    axes.plot(axis.values, values.mean(axis=0), lw=1.5, **style)  # type: ignore[arg-type]


def _routes(axes: Axes, outcome: Outcome) -> None:
    colours = iter((RED, ORANGE, PURPLE, INK))
    for case, _ in outcome.samples:
        if "route" in case:
            label = f"{case['n_uav']} sweeping, {case['route']} lanes"
            _curve(axes, outcome, case, "covered@step", color=next(colours), ls="--", label=label)


def _over(axes: Axes, outcome: Outcome, key: str, metric: str, colour: str) -> None:
    """A metric's mean and quartiles over one key, of the cases that have no other."""
    rows = [
        row
        for row in outcome.rows
        if set(row.case) == {key} and row.metric == metric and row.mean is not None
    ]
    at = [float(row.case[key]) for row in rows]
    low, high = [row.q25 or 0.0 for row in rows], [row.q75 or 0.0 for row in rows]
    axes.fill_between(at, low, high, color=colour, alpha=0.15, lw=0)
    axes.plot(at, [row.mean or 0.0 for row in rows], "o-", ms=4, color=colour)
    axes.set_xlabel("UAVs")


def _swept(axes: Axes, outcome: Outcome, key: str, label: str) -> None:
    """Both times over a swept key; the plain case stands where its parameter is."""
    for metric, colour, name in (
        ("steps_all_found", INDIGO, "until all found"),
        ("revisit_response", GREEN, "to answer"),
    ):
        points = []
        for row in outcome.rows:
            if row.metric != metric or row.mean is None or row.reading is not None:
                continue
            if set(row.case) == {"n_uav", key}:
                points.append((float(row.case[key]), row.mean))
            elif row.case == {"n_uav": outcome.params.swept_uavs}:
                points.append((float(getattr(outcome.params, key)), row.mean))
        points.sort()
        axes.plot(*zip(*points, strict=True), "o-", ms=4, color=colour, label=name)
    axes.set_yscale("log")
    axes.set_xlabel(f"{label}; {outcome.params.swept_uavs} UAVs")
    axes.set_title("steps", loc="left", color=INK)
    axes.legend(frameon=False, fontsize=7)


def navigation(figure: Figure, outcome: Outcome) -> None:
    """Figs 9 and 10: the ways of the three leaders, and a flock in the working form."""
    from uavbridge.experiments.runner import seeds_of
    from uavbridge.experiments.shao.journey import LEADERS, travel
    from uavbridge.experiments.shao.navigate import course

    figure.set_size_inches(11.5, 4.2)
    ways, flock, counts = figure.subplots(1, 3)
    params = outcome.params
    seeds = seeds_of(outcome.experiment, {"leader": "vector"}, outcome.seed, 1)
    obstacles, start, goal, places = course(params, seeds)
    for axes in (ways, flock):
        axes.imshow(obstacles[0].T, origin="lower", cmap="Greys", vmax=1.6)
        axes.plot(*goal[0], "*", ms=12, color=ORANGE)
    for leader, colour in zip(LEADERS, (RED, INDIGO, GREEN), strict=True):
        journey = params.journey(leader, "working", params.radius)
        track = [
            np.vstack((state.leader, state.position[0]))
            for state in travel(obstacles, start, goal, places, journey, params.steps)
        ]
        steps = np.array(track)
        ways.plot(*steps[:, 0].T, color=colour, lw=1.4, label=f"{leader}: {len(track) - 1} steps")
        if leader == "vector":
            for follower in range(1, steps.shape[1]):
                flock.plot(*steps[:, follower].T, color=FAINT, lw=0.9)
            flock.plot(*steps[:, 0].T, color=RED, lw=1.4)
            flock.plot(*steps[-1, 1:].T, "o", ms=4, color=INK)
    ways.legend(frameon=False, fontsize=8)
    ways.set_title("leaders", loc="left", color=INK)
    flock.set_title("followers, working form", loc="left", color=INK)
    rows = [row for row in outcome.rows if row.metric == "iterations" and row.mean is not None]
    for place, row in enumerate(rows):
        counts.plot(place, row.mean, "o", color=INDIGO)
        if row.paper is not None:
            counts.plot(place, row.paper, "_", ms=16, mew=2.2, color=INK)
    counts.set_xticks(range(len(rows)), [str(row.case["leader"]) for row in rows])
    counts.set_ylim(bottom=0.0)
    counts.set_title("steps, printed as a bar", loc="left", color=INK)
    plain(counts)


def maps(figure: Figure, outcome: Outcome) -> None:
    """Fig. 7: routes and path pheromone when all were found, target and combined later."""
    from uavbridge.experiments.runner import seeds_of
    from uavbridge.experiments.shao.maps import SHOWN_STEP, take

    figure.set_size_inches(10.5, 8.6)
    (routes, path), (target, combined) = figure.subplots(2, 2)
    case = dict(outcome.samples[0][0])
    shown = take(case, outcome.params, seeds_of(outcome.experiment, case, outcome.seed, 1))
    routes.imshow(shown.ground.obstacles[0].T, origin="lower", cmap="Greys", vmax=1.6)
    for uav in range(shown.routes.shape[1]):
        routes.plot(*shown.routes[:, uav].T, lw=0.9, alpha=0.8)
    last = len(shown.routes) - 1
    world = outcome.params.world
    for axes, values, title in (
        (routes, None, f"routes, step {last}"),
        (path, shown.path, f"path pheromone, step {last}"),
        (target, shown.late.target, f"target pheromone, step {SHOWN_STEP}"),
        (combined, shown.late.combined(world.weights), f"combined, step {SHOWN_STEP}"),
    ):
        if values is not None:
            image = axes.imshow(values.T, origin="lower", cmap="viridis")
            figure.colorbar(image, ax=axes, shrink=0.8)
        axes.plot(*shown.ground.targets[0].T, "*", ms=10, color=RED)
        axes.set_title(title, loc="left", color=INK)


def faults(figure: Figure, outcome: Outcome) -> None:
    """Coverage, targets found and signals that wait, over the number of failures."""
    figure.set_size_inches(11.5, 3.6)
    names = {
        "coverage": "coverage at the end",
        "targets_found": "targets found",
        "revisit_response": "steps to answer a signal",
        "unanswered": "signals that wait at the end",
    }
    for axes, (metric, title) in zip(figure.subplots(1, 4), names.items(), strict=True):
        for search, colour in (("pheromones", GREEN), ("routes", PURPLE)):
            rows = [
                row
                for row in outcome.rows
                if row.case["search"] == search and row.metric == metric and row.mean is not None
            ]
            at = [float(row.case["failed"]) for row in rows]
            error = [row.se or 0.0 for row in rows]
            mean = [row.mean or 0.0 for row in rows]
            axes.errorbar(at, mean, error, fmt="o-", ms=4, color=colour, label=search)
        axes.set_xlabel(f"of {outcome.params.swept_uavs} UAVs that fail")
        axes.set_title(title, loc="left", color=INK)
        axes.set_ylim(bottom=0.0)
        plain(axes)
    figure.axes[0].legend(frameon=False)


def scenario(figure: Figure, outcome: Outcome) -> None:
    """Steps until the group is there, all is found, all is revisited."""
    figure.set_size_inches(7.0, 3.9)
    axes = figure.subplots()
    for metric, colour, label in (
        ("steps_there", INDIGO, "group is there"),
        ("steps_all_found", GREEN, "all found"),
        ("steps_all_revisited", ORANGE, "all revisited"),
    ):
        rows = [row for row in outcome.rows if row.metric == metric and row.mean is not None]
        at = [float(row.case["n_uav"]) for row in rows]
        mean = [row.mean or 0.0 for row in rows]
        error = [row.se or 0.0 for row in rows]
        axes.errorbar(at, mean, error, fmt="o-", ms=4, color=colour, label=label)
    axes.set_xlabel("UAVs, the leader among them")
    axes.set_title("steps from the start", loc="left", color=INK)
    axes.set_ylim(bottom=0.0)
    axes.legend(frameon=False)
    plain(axes)


def places(figure: Figure, outcome: Outcome) -> None:
    """Bytes, and times until everything is found and seen, by form."""
    figure.set_size_inches(9.6, 3.6)
    left, right = figure.subplots(1, 2)
    labels = [" ".join(str(part) for part in case.values()) for case, _ in outcome.samples]
    at = np.arange(len(labels))
    sent, told = (
        np.array([samples[name].mean() for _, samples in outcome.samples])
        for name in ("bytes_per_agent_s", "answer_bytes_per_agent_s")
    )
    left.barh(at, sent, color=INDIGO, label="sent by a UAV")
    left.barh(at, told, left=sent, color=ORANGE, label="answers to it")
    left.set_title("bytes a second and UAV", loc="left", color=INK)
    left.legend(frameon=False, fontsize=7)
    for metric, colour, label in (("coverage_s", GREEN, "seen"), ("goal_s", RED, "and found")):
        values = [samples[metric] for _, samples in outcome.samples]
        means = [np.nanmean(part) if np.isfinite(part).any() else np.nan for part in values]
        right.plot(means, at, "o", color=colour, label=label)
    right.set_title("seconds", loc="left", color=INK)
    right.legend(frameon=False, fontsize=7)
    for axes in (left, right):
        axes.set_yticks(at, labels)
        axes.set_xlim(left=0.0)
        plain(axes)
