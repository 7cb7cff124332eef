"""A plan: jobs, trainings, frames, disk and multiply-adds of a target."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from foggy_synscapes.jobs import Job
from foggy_synscapes.params import Params
from foggy_synscapes.planning import asked, costs
from foggy_synscapes.results import root


@dataclass(frozen=True)
class Plan:
    """What a target takes.

    datasets : folder of each dataset that is read; jobs : number by word
    trainings : network, row, seed, images_seen, validations, batch
    frames : clear frames of Synscapes that fog is made on; foggy_images : images made of them
    disk_bytes : see `costs.disk`; multiply_adds : by "training", "validation" and "evaluation"
    unknown : test sets of which nobody says how large they are, so that their evaluation is not counted
    """

    datasets: dict[str, str]
    jobs: dict[str, int]
    trainings: list[dict[str, Any]]
    frames: int
    foggy_images: int
    disk_bytes: int
    multiply_adds: dict[str, int]
    unknown: list[str]
    by_network: dict[str, dict[str, float]]

    def document(self) -> dict[str, Any]:
        """The plan as `foggy plan --json` prints it."""
        return {
            "jobs": self.jobs,
            "trainings": self.trainings,
            "datasets": self.datasets,
            "frames": self.frames,
            "foggy_images": self.foggy_images,
            "disk_bytes": self.disk_bytes,
            "multiply_adds": sum(self.multiply_adds.values()),
            "multiply_adds_of": self.multiply_adds,
        }


def plan(params: Params, targets: Iterable[str] = ("all",)) -> tuple[Plan, list[Job]]:
    """What these targets take, and their jobs; UsageError where there is no such target."""
    jobs = asked.jobs(params, targets)
    of = {(each.network, each.row): each for each in params.trainings()}
    trainings, unknown = [], []
    spent: dict[str, dict[str, float]] = {}
    for job in jobs:
        word, values = job.step.word, job.values
        if word not in ("train", "evaluate"):
            continue
        network = values["network"]
        each = spent.setdefault(network, {"training": 0.0, "validation": 0.0, "evaluation": 0.0})
        training = of.get((network, values["row"]))
        if word == "train" and training is not None:
            each["training"] += costs.steps(params, training)
            each["validation"] += costs.validations(params, training)
            trainings.append(
                {
                    "network": network,
                    "row": training.row,
                    "seed": values["seed"],
                    "images_seen": training.images_seen,
                    "validations": training.validations,
                    "batch": training.policy.batch,
                }
            )
        elif word == "evaluate":
            cost = costs.evaluation(params, network, values["test_set"])
            each["evaluation"] += cost
            unknown += [] if cost else [values["test_set"]]
    shards = {job.values["shard"] for job in jobs if job.step.name == "fog_airlight"}
    made = Counter(
        (job.step.name, job.values["beta"], job.values.get("model"))
        for job in jobs
        if job.step.name in ("fog", "fog_model", "fog_completed")
    )
    found = Plan(
        datasets={name: str(root(params, name)) for name in datasets(jobs)},
        jobs=dict(Counter(job.step.word for job in jobs)),
        trainings=trainings,
        frames=costs.fogged(params, len(shards)),
        foggy_images=sum(costs.fogged(params, count) for count in made.values()),
        disk_bytes=round(costs.disk(params, jobs)),
        multiply_adds={kind: round(sum(each[kind] for each in spent.values())) for kind in KINDS},
        unknown=list(dict.fromkeys(unknown)),
        by_network=spent,
    )
    return found, jobs


KINDS = ("training", "validation", "evaluation")


def datasets(jobs: Iterable[Job]) -> list[str]:
    """Datasets that jobs read or draw."""
    return [job.step.name.removeprefix("scenes_") for job in jobs if job.step.word == "scenes"]
