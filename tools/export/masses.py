"""Mass and centre of mass of exported robots as MuJoCo reads them, beside those that mlr-ga states.

    venv/bin/python tools/export/masses.py target/release/mlr-ga
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import mujoco
import numpy as np

from walk import CASES


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path)
    program = parser.parse_args().program.resolve()
    print("| robot | format | joints | mass [kg] | off by [kg] | centre of mass off by [m] |")
    print("|:--|:--|--:|--:|--:|--:|")
    for name, case in CASES.items():
        for form in ("urdf", "mjcf"):
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / f"robot.{form if form == 'urdf' else 'xml'}"
                arguments = [program, "export", "--format", form, "-o", file, "--json", *case]
                stated = json.loads(subprocess.run(arguments, check=True, capture_output=True).stdout)
                model = mujoco.MjModel.from_xml_path(str(file))
            data = mujoco.MjData(model)
            mujoco.mj_forward(model, data)
            body = model.body("base_link").id
            center = data.subtree_com[body] - data.xpos[body]
            mass = model.body_subtreemass[body]
            joints = sum(kind == mujoco.mjtJoint.mjJNT_HINGE for kind in model.jnt_type)
            assert joints == stated["joints"], (joints, stated["joints"])
            apart = np.abs(center - stated["center_of_mass_straight_m"]).max()
            print(f"| {name} | {form} | {joints} | {mass:.5f} | {abs(mass - stated['mass_kg']):.0e} | {apart:.0e} |")


if __name__ == "__main__":
    main()
