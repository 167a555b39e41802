"""The paper's evidence, reproduced: its 18 tests by both methods, and its figures.

Draws the tests from the plant (`tools/plant/draw.py tests`), runs `--method paper` and the default
ten times on each, and writes the tables into `docs/paper.md`, which says what agrees with the
paper and what does not, and the figures into `docs/paper/` as SVG. Every answer is kept in the
output directory, so that a run that was broken off goes on where it stopped.

    python3 -m venv venv && venv/bin/pip install -r tools/paper/requirements.txt
    cargo build --release -p mlr-ga
    target/release/mlr-ga atlas build -o jethexa.atlas
    venv/bin/python tools/paper/reproduce.py --atlas jethexa.atlas -o paper
"""

import argparse
import csv
import gzip
import json
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np

import figures

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target" / "release" / "mlr-ga"
SEED, RUNS = 18, 10
SCENARIOS = [  # the paper's tests, right ones, minutes and prediction (its tables), in the order of `draw.py tests`
    ("leg 3 lost", 2, 1, 9.47, "111 110 000 111 111 111"),
    ("leg 5 lost", 2, 1, 9.62, "111 111 111 111 100 111"),
    ("legs 1, 4 lost", 4, 4, 9.41, "110 111 111 100 111 111"),
    ("legs 3, 4 lost", 2, 2, 9.73, "111 111 100 110 111 111"),
    ("legs 3, 4 without their last two links", 2, 2, 9.38, "111 111 110 110 111 111"),
    ("legs 3, 4 without their last link", 2, 2, 9.81, "111 111 110 110 111 111"),
    ("legs 4, 5 lost", 2, 2, 9.06, "111 111 111 100 100 111"),
    ("legs 2, 3 lost", 2, 2, 9.44, "111 000 110 111 111 111"),
]
TABLES = "<!-- tables -->\n", "<!-- end of tables -->\n"
HARSH = 18  # index of the test on harsh ground
CONVERGENCE = 14  # index of a test of legs 4 and 5, whose convergence the paper shows


def run(*arguments):
    return subprocess.run([str(a) for a in arguments], check=True, capture_output=True, text=True).stdout


def kept(path, make):
    """What `make` returns, from `path` where an earlier run has left it."""
    if not path.exists():
        path.write_text(json.dumps(make()))
    return json.loads(path.read_text())


def draw(output):
    logs = output / "logs"
    if not (logs / "truth.json").exists():
        plant = ROOT / "tools" / "plant" / "draw.py"
        run(sys.executable, plant, "tests", "--seed", SEED, "--count", HARSH + 1, "-o", logs)
    return logs


def identify(log, *options):
    return json.loads(run(PROGRAM, "identify", log, "--json", *options))


def by_paper(log):
    """One call: its preset runs the algorithm ten times. The time is that of one run."""
    return identify(log, "--method", "paper", "--repeats", RUNS, "--seed", 1)


def by_default(log, atlas):
    """Ten seeds of the genetic algorithm on the atlas's walks; the time is that of a run without atlas."""
    runs = [identify(log, "--search", "ga", "--atlas", atlas, "--seed", seed) for seed in range(1, RUNS + 1)]
    return {"runs": runs, "elapsed_s": identify(log, "--search", "ga")["elapsed_s"]}


def spelled(rows):
    return " ".join("".join(map(str, leg)) for leg in rows)


def damaged(rows):
    return [leg + 1 for leg, links in enumerate(rows) if 0 in links]


def frequency(results):
    """The most frequent result, and how often it came."""
    counts = {}
    for result in results:
        counts[result] = counts.get(result, 0) + 1
    best = max(counts, key=counts.get)
    return best, counts[best]


def answers(logs, output, atlas):
    """For each test: the truth and both methods' answers."""
    truths = json.loads((logs / "truth.json").read_text())
    tests = []
    for index, name in enumerate(sorted(truths)):
        log = logs / f"{name}.csv.gz"
        paper = kept(output / f"{name}-paper.json", lambda: by_paper(log))
        default = kept(output / f"{name}-mlr.json", lambda: by_default(log, atlas))
        print(f"{index + 1} of {len(truths)}", file=sys.stderr)
        truth = truths[name]["morphology"]
        legs = damaged(truth)
        of_truth, _ = compared(log, spelled(truth), output, "truth")
        best = spelled(paper["morphology"])
        count = sum(run["morphology"] == paper["morphology"] for run in paper["runs"])
        ours, our_count = frequency([spelled(r["morphology"]) for r in default["runs"]])
        tests.append({
            "log": log, "actual": spelled(truth), "paper": paper,
            "paper_best": best, "paper_count": count, "paper_cost_rad": paper["cost_rad"],
            "truth_cost_rad": of_truth["cost_rad"],
            "paper_right": damaged(paper["morphology"]) == legs,
            "paper_runs_right": sum(damaged(r["morphology"]) == legs for r in paper["runs"]),
            "paper_time_s": paper["elapsed_s"] / RUNS,
            "mlr_best": ours, "mlr_count": our_count,
            "mlr_right": damaged([[int(c) for c in leg] for leg in ours.split()]) == legs,
            "mlr_runs_right": sum(damaged(r["morphology"]) == legs for r in default["runs"]),
            "mlr_time_s": default["elapsed_s"],
            "mlr_probability": statistics.mean(r["legs_probability"] for r in default["runs"]),
        })
    return tests


def summary(tests):
    lines = [
        "| scenario | tests | the paper: right | minutes | `--method paper`: right | runs right | seconds a run"
        " | `mlr`: right | runs right | seconds a run |",
        "|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    first = 0
    totals = [0] * 6
    for name, count, right, minutes, _ in SCENARIOS:
        of = tests[first:first + count]
        first += count
        values = [count, right, sum(t["paper_right"] for t in of), sum(t["paper_runs_right"] for t in of),
                  sum(t["mlr_right"] for t in of), sum(t["mlr_runs_right"] for t in of)]
        totals = [a + b for a, b in zip(totals, values)]
        times = [statistics.mean(t[key] for t in of) for key in ("paper_time_s", "mlr_time_s")]
        lines.append(
            f"| {name} | {count} | {right} | {minutes:.2f} | {values[2]} | {values[3]} of {RUNS * count} | {times[0]:.1f}"
            f" | {values[4]} | {values[5]} of {RUNS * count} | {times[1]:.1f} |")
    times = [statistics.mean(t[key] for t in tests[:first]) for key in ("paper_time_s", "mlr_time_s")]
    lines.append(
        f"| all | {totals[0]} | {totals[1]} | 9.48 | {totals[2]} | {totals[3]} of {RUNS * totals[0]} | {times[0]:.1f}"
        f" | {totals[4]} | {totals[5]} of {RUNS * totals[0]} | {times[1]:.1f} |")
    return "\n".join(lines)


def each(tests):
    lines = [
        "| test | actual | the paper predicts | `--method paper` | runs | its F [rad] | F of the truth | `mlr` | runs"
        " | probability of the legs |",
        "|:--|:--|:--|:--|--:|--:|--:|:--|--:|--:|",
    ]
    named = [(name, predicted) for name, count, _, _, predicted in SCENARIOS for _ in range(count)]
    named.append(("legs 1, 4 lost, harsh ground", "110 111 111 100 111 111"))
    for index, (test, (name, predicted)) in enumerate(zip(tests, named)):
        mark = {True: "", False: " ✗"}
        lines.append(
            f"| {index + 1} {name} | {test['actual']} | {predicted} | {test['paper_best']}{mark[test['paper_right']]}"
            f" | {test['paper_count']} of {RUNS} | {test['paper_cost_rad']:.1f} | {test['truth_cost_rad']:.1f}"
            f" | {test['mlr_best']}{mark[test['mlr_right']]}"
            f" | {test['mlr_count']} of {RUNS} | {100 * test['mlr_probability']:.0f} % |")
    return "\n".join(lines)


def columns(path):
    opened = gzip.open(path, "rt") if path.suffix == ".gz" else open(path)
    with opened as file:
        rows = list(csv.reader(file))
    values = np.array(rows[1:], dtype=float)
    return {name: values[:, index] for index, name in enumerate(rows[0])}


def compared(log, morphology, output, name):
    """F of a morphology, and the conditioned signals."""
    path = output / f"{name}.csv"
    path.unlink(missing_ok=True)
    report = json.loads(run(PROGRAM, "compare", log, "--morphology", morphology, "--method", "paper", "--signals", path, "--json"))
    return report, columns(path)


def draw_figures(tests, logs, output, to):
    example = tests[CONVERGENCE]
    samples = 5.0 * 250.0
    figures.convergence(example["paper"]["runs"], 3 * samples, "legs 4 and 5 lost", to / "convergence.svg")
    harsh = tests[HARSH]
    figures.convergence(harsh["paper"]["runs"], 3 * samples, "legs 1 and 4 lost, harsh ground", to / "convergence-harsh.svg")
    truth, wrong = "111 111 111 000 000 111", "111 111 000 111 000 111"
    pair = [compared(example["log"], morphology, output, name) for morphology, name in ((truth, "right"), (wrong, "wrong"))]
    figures.right_and_wrong(pair, [f"right: {truth}", f"wrong: {wrong}"], to / "right-and-wrong.svg")
    for test, name in ((example, "spectra"), (harsh, "spectra-harsh")):
        report, signals = compared(test["log"], test["mlr_best"], output, name)
        figures.spectra(columns(test["log"]), report["window_start_s"], signals, to / f"{name}.svg")
    plant = json.loads((logs / "truth.json").read_text())[harsh["log"].name.removesuffix(".csv.gz")]["plant"]
    sys.path.insert(0, str(ROOT / "tools" / "plant"))
    figures.terrain(plant, to / "terrain.svg")
    detection = to / "detection.svg"
    detection.unlink(missing_ok=True)
    run(PROGRAM, "detect", ROOT / "data/logs/stand-in/detect-legs3-4.csv.gz", "--plot", detection)


def write_tables(tables):
    document = ROOT / "docs" / "paper.md"
    text = document.read_text()
    before, rest = text.split(TABLES[0])
    _, after = rest.split(TABLES[1])
    document.write_text(f"{before}{TABLES[0]}{tables}{TABLES[1]}{after}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--atlas", type=Path, required=True)
    parser.add_argument("-o", "--output", type=Path, required=True)
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    to = ROOT / "docs" / "paper"
    to.mkdir(exist_ok=True)
    logs = draw(args.output)
    tests = answers(logs, args.output, args.atlas)
    write_tables(f"{summary(tests)}\n\n{each(tests)}\n")
    draw_figures(tests, logs, args.output, to)


if __name__ == "__main__":
    main()
