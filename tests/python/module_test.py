"""The Python module gives what the program gives: images to the bit, errors to the word, logs to the field.

etendue-python module_test.py PROGRAM PROJECT, or any Python that finds the module. Exit status 77: NumPy is not installed.
"""
import concurrent.futures
import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import etendue

program, project = sys.argv[1:3]
try:
    import numpy
except ImportError as missing:
    print("skipped:", missing)
    sys.exit(77)

EXPERIMENT = """
title = "Small"
scenes = ["builtin:lambert-sphere"]
seeds = 2
budget = { samples = 4 }
resolution = [16, 16]
integrators = ["path", { name = "photon-map", photons = "2k" }]
"""


def call(*arguments):
    return subprocess.run([program, *arguments], capture_output=True, text=True)


class Module(unittest.TestCase):
    def setUp(self):
        self.before = os.getcwd()
        self.folder = tempfile.TemporaryDirectory()
        os.chdir(self.folder.name)
        os.environ["XDG_CACHE_HOME"] = self.folder.name
        with open("small.toml", "w") as file:
            file.write(EXPERIMENT)

    def tearDown(self):
        os.chdir(self.before)
        self.folder.cleanup()

    def test_renders_the_bits_of_the_program(self):
        for method in ("path", "sppm"):
            ours = etendue.render(etendue.load("builtin:cornell-spheres"), {"name": method, "max_depth": 5}, samples=3,
                                  resolution=(24, 16), seed=7, threads=1)
            arguments = ["--spp", "3", "--resolution", "24x16", "--seed", "7", "-i", method, "-p", "max_depth=5"]
            theirs = json.loads(call("render", "builtin:cornell-spheres", *arguments, "-o", "a.exr", "--json").stdout)
            self.assertEqual(ours["image_hash"], theirs["image_hash"])
            self.assertEqual(ours["iterations"], 3)
            self.assertEqual(ours["counters"], theirs["counters"])
            self.assertEqual(ours["image"].shape, (16, 24, 3))
            self.assertEqual(ours["image"].dtype, numpy.float32)
            self.assertEqual(etendue.compare(ours["image"], "a.exr")["mse"], 0)

    def test_ends_with_the_time(self):
        timed = etendue.render(etendue.load("builtin:furnace"), time="500ms", resolution=(8, 8))
        self.assertGreater(timed["iterations"], 1)
        self.assertLess(timed["time_s"], 5)

    def test_measures_errors_as_the_program_does(self):
        scene = etendue.load("builtin:polygon-light")
        truth = etendue.reference(scene, resolution=(16, 16))
        image = etendue.render(scene, samples=4, resolution=(16, 16))["image"]
        arguments = ["--spp", "4", "--resolution", "16x16", "-o", "b.exr", "--json"]
        theirs = json.loads(call("render", "builtin:polygon-light", *arguments).stdout)
        self.assertAlmostEqual(etendue.compare(image, truth)["relmse"] / theirs["relmse"], 1, places=4)
        with self.assertRaisesRegex(etendue.Error, "16 x 16 pixels; expected 8 x 8"):
            etendue.compare(image, truth[:8, :8])
        with self.assertRaisesRegex(etendue.Error, "expected an array of height x width x 3"):
            etendue.compare(image[0], truth)
        with self.assertRaisesRegex(etendue.Error, "expected an array of height x width x 3"):
            etendue.compare({}, truth)

    def test_warns_of_light_out_of_reach(self):
        water = etendue.load("builtin:water")
        with self.assertWarnsRegex(UserWarning, "path leaves it out; cppm brings it"):
            rendered = etendue.render(water, "path", samples=1, resolution=(16, 16))
        self.assertIn("cppm", rendered["out_of_reach"])
        chosen = etendue.render(water, "auto", samples=1, resolution=(16, 16))
        self.assertNotIn("out_of_reach", chosen)
        self.assertEqual(chosen["chosen"], "cppm")
        self.assertTrue(chosen["chosen_accel"])

    def test_warns_of_a_reference_that_is_unproven(self):
        caustic = etendue.load("builtin:glass-caustic")
        with self.assertWarnsRegex(UserWarning, "is used, but unproven"):
            etendue.reference(caustic, samples=64, resolution=(32, 24))

    def test_ends_a_reference_with_an_interrupt(self):
        timer = threading.Timer(1, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            etendue.reference(etendue.load("builtin:cornell-spheres"), samples=10**6, resolution=(64, 64))

    def test_refuses_what_the_program_refuses(self):
        scene = etendue.load("builtin:furnace")
        with self.assertRaisesRegex(ValueError, "did you mean 'builtin:cornell-box'|cornell-box"):
            etendue.load("builtin:cornel-box")
        with self.assertRaisesRegex(etendue.Error, "integrator: unknown integrator 'pth'"):
            etendue.render(scene, "pth", samples=1)
        with self.assertRaisesRegex(etendue.Error, "unknown parameter 'photos'"):
            etendue.render(scene, {"name": "sppm", "photos": 3}, samples=1)
        with self.assertRaisesRegex(etendue.Error, "expected samples or time"):
            etendue.render(scene)
        with self.assertRaisesRegex(etendue.Error, "samples: 0 is out of range"):
            etendue.render(scene, samples=0)
        with self.assertRaisesRegex(etendue.Error, "samples: 1 is out of range; expected 16 .. "):
            etendue.reference(scene, samples=1, resolution=(8, 8))
        with self.assertRaisesRegex(etendue.Error, "each in 1 .. 16384"):
            etendue.render(scene, samples=1, resolution=(0, 4))
        with open("wrong.toml", "w") as file:
            file.write(EXPERIMENT.replace("seeds", "seds"))
        with self.assertRaises(etendue.Error) as refused:
            etendue.run("wrong.toml")
        self.assertIn(str(refused.exception), call("run", "wrong.toml").stderr)

    def test_runs_experiments_and_reads_their_logs(self):
        lines = []
        done = etendue.run("small.toml", out="ours", threads=1, on_line=lines.append)
        self.assertEqual((done["directory"], done["done"], done["failed"]), ("ours", 4, 0))
        self.assertTrue(any("path" in line for line in lines))
        self.assertEqual(call("run", "small.toml", "--out", "theirs", "--threads", "1").returncode, 0)
        ours, theirs = etendue.read_log("ours"), etendue.read_log(["theirs"])
        self.assertEqual([cell["image_hash"] for cell in ours["cell"]], [cell["image_hash"] for cell in theirs["cell"]])
        self.assertEqual(ours["cell"][-1]["integrator"], "photon-map photons=2000")
        self.assertEqual(ours["cell"][-1]["parameters"], {"photons": 2000})
        self.assertEqual(ours["cell"][0]["declared_bias"], "unbiased")
        self.assertEqual(len(ours["checkpoint"]), sum(cell["checkpoints"] for cell in ours["cell"]))
        self.assertEqual(etendue.curves("ours"), call("report", "ours", "--csv").stdout)

    def test_goes_on_after_an_exception(self):
        def refuse(line):
            if "seed 2" in line or "done" in line:
                raise KeyError(line)

        with self.assertRaises(KeyError):
            etendue.run("small.toml", out="stopped", threads=1, on_line=refuse)
        again = etendue.run("small.toml", out="stopped", threads=1)
        self.assertGreater(again["skipped"], 0)
        self.assertEqual(again["skipped"] + again["done"], 4)

    def test_listeners_may_render(self):
        scene, hashes = etendue.load("builtin:furnace"), []

        def look(line):
            hashes.append(etendue.render(scene, samples=1, threads=1, resolution=(8, 8))["image_hash"])

        etendue.run("small.toml", out="looked", threads=1, on_line=look)
        self.assertEqual(len(set(hashes)), 1)

    def test_renders_of_several_threads_take_turns(self):
        scene = etendue.load("builtin:cornell-box")

        def render(_):
            image = etendue.render(scene, integrator="auto", samples=4, threads=1, resolution=(16, 16))
            return image["image_hash"], image["counters"]

        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            both = list(pool.map(render, range(2)))
        self.assertEqual(both, [render(0)] * 2)

    def test_ends_with_an_interrupt(self):
        code = "import etendue; etendue.render(etendue.load('builtin:furnace'), time=100, threads=1)"
        render = subprocess.Popen([sys.executable, "-c", "print(1, flush=True); " + code], stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True)
        render.stdout.readline()
        time.sleep(0.5)
        render.send_signal(signal.SIGINT)
        self.assertIn("KeyboardInterrupt", render.communicate(timeout=60)[1])

    def test_documented_examples_run(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.skipTest("pandas is not installed")
        os.symlink(os.path.join(project, "experiments"), "experiments")
        with open(os.path.join(project, "docs/python.md")) as page:
            blocks = page.read().split("```python\n")[1:]
        code = "\n".join(block.split("```")[0] for block in blocks)
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(code, "docs/python.md", "exec"), {})
        self.assertIn("irradiance-cache", printed.getvalue())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
