# SPDX-License-Identifier: MIT
# The Python package. Arguments: the specification's set V1, and the program `ntc`.
import pathlib
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy

import openntc

V1 = pathlib.Path(sys.argv.pop(1))
NTC = sys.argv.pop(1)

# Texel (13, 7) of mip 0 of V1, as printed in the format specification.
EXPECTED = [0x3EC6DC00, 0xBCE30400, 0x3EB4F0A0, 0xBC7ED400, 0x3E106800, 0xBF77F220, 0x3F6CFA60, 0x3E2CC740,
            0xBE586980, 0x3EC32C40, 0xBF44D880, 0xBF6EC1D0, 0x3FB7E3A0, 0xBE332180, 0xBF1DFE00, 0xBD6FD600]


def make_images():
    """32 x 32 colours with a gradient and a check pattern, and heights."""
    y, x = numpy.mgrid[0:32, 0:32]
    colors = numpy.stack([8 * x, 8 * y, 255 * ((x // 8 + y // 8) % 2)], axis=2).astype(numpy.uint8)
    heights = (x * y * 68).astype(numpy.uint16)
    return {"BaseColor": openntc.Image(colors, srgb=True), "Height": heights}


class Reading(unittest.TestCase):
    def test_texels_have_the_bits_of_the_specification(self):
        texture_set = openntc.TextureSet(V1)
        for threads in (0, 1):
            texels = texture_set.decode(0, rect=(13, 7, 1, 1), threads=threads)
            self.assertEqual(texels.shape, (1, 1, texture_set.channels))
            words = texels.view(numpy.uint32).ravel().tolist()
            self.assertEqual(words, EXPECTED[: texture_set.channels])

    def test_rectangles_and_textures_are_parts_of_the_whole(self):
        texture_set = openntc.TextureSet(str(V1))
        whole = texture_set.decode()
        self.assertEqual(whole.shape, (texture_set.height, texture_set.width, texture_set.channels))
        self.assertEqual(whole.dtype, numpy.float32)
        part = texture_set.decode(rect=(3, 2, 5, 4))
        numpy.testing.assert_array_equal(part, whole[2:6, 3:8])
        for texture in texture_set.textures:
            first = texture.first_channel
            numpy.testing.assert_array_equal(texture_set.texture(texture.name), whole[:, :, first : first + texture.channels])
        for mip in range(texture_set.mips):
            self.assertEqual(texture_set.decode(mip).shape[:2], texture_set.mip_size(mip)[::-1])

    def test_maths_modes_are_near_each_other(self):
        texture_set = openntc.TextureSet(V1)
        exact = texture_set.decode(math="fp32", rect=(0, 0, 8, 8))
        self.assertFalse(numpy.array_equal(exact, texture_set.decode(rect=(0, 0, 8, 8))))
        self.assertTrue(numpy.isfinite(exact).all())

    def test_threads_decode_one_set(self):
        texture_set = openntc.TextureSet(V1)
        results = [None] * 4

        def work(i):
            results[i] = texture_set.decode()

        threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for result in results:
            numpy.testing.assert_array_equal(result, results[0])

    def test_shader_inputs_are_those_of_ntc_export(self):
        texture_set = openntc.TextureSet(V1)
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([NTC, "export", V1, "-o", folder], check=True, stdout=subprocess.DEVNULL)
            files = {name: (pathlib.Path(folder) / f"{name}.bin").read_bytes() for name in ("constants", "weights", "latents")}
        self.assertEqual(texture_set.constants(), files["constants"])
        self.assertEqual(texture_set.weights(), files["weights"])
        self.assertEqual(texture_set.latents(), files["latents"])
        constants, latents = texture_set.slice((0, 0, 8, 8), mips=1)
        self.assertEqual(len(constants), len(files["constants"]))
        self.assertLess(len(latents), len(files["latents"]))

    def test_errors_name_field_value_and_limit(self):
        with self.assertRaisesRegex(openntc.Error, "none.ntc"):
            openntc.TextureSet("none.ntc")
        with tempfile.TemporaryDirectory() as folder:
            short = pathlib.Path(folder) / "short.ntc"
            short.write_bytes((V1).read_bytes()[:200])
            with self.assertRaisesRegex(ValueError, "header|json"):
                openntc.TextureSet(short)
        texture_set = openntc.TextureSet(V1)
        for call, text in (
            (lambda: texture_set.decode(99), "mip: 99: the set has"),
            (lambda: texture_set.decode(-1), "mip: -1"),
            (lambda: texture_set.decode(rect=(0, 0, 0, 1)), r"rect: \(0, 0, 0, 1\)"),
            (lambda: texture_set.decode(rect=(2147483647, 0, 2147483647, 1)), "rect: "),
            (lambda: texture_set.decode(math="int4"), "math: int4: must be int8"),
            (lambda: texture_set.decode(threads=-1), "threads: -1"),
            (lambda: texture_set.latents(0, 99), "99"),
            (lambda: texture_set.weights("int4"), "weights: int4"),
            (lambda: texture_set.slice((0, 0, 0, 0)), "0"),
        ):
            with self.assertRaisesRegex(ValueError, text):
                call()
            with self.assertRaises(openntc.Error):
                call()
        with self.assertRaisesRegex(KeyError, "Nothing: the set has "):
            texture_set.texture("Nothing")

    def test_bytes_are_a_set_too(self):
        data = V1.read_bytes()
        for source in (data, bytearray(data), memoryview(data)):
            texture_set = openntc.TextureSet(source)
            self.assertIsNone(texture_set.path)
            numpy.testing.assert_array_equal(texture_set.decode(1), openntc.TextureSet(V1).decode(1))
            self.assertEqual(texture_set.slice((0, 0, 8, 8), mips=1), openntc.TextureSet(V1).slice((0, 0, 8, 8), mips=1))
        with self.assertRaisesRegex(openntc.Error, "bytes: "):
            openntc.TextureSet(data[:100])
        with self.assertRaisesRegex(openntc.Error, "bytes: "):
            openntc.TextureSet(b"")


class Encoding(unittest.TestCase):
    def test_what_was_encoded_is_read_back_at_the_promised_quality(self):
        images = make_images()
        for generation in (1, 3):
            with self.subTest(generation=generation), tempfile.TemporaryDirectory() as folder:
                result = openntc.encode(images, steps=400, bits_per_pixel=8, generation=generation, mips=1, threads=1)
                path = pathlib.Path(folder) / "set.ntc"
                result.save(path)
                self.assertEqual([entry.name for entry in pathlib.Path(folder).iterdir()], ["set.ntc"])
                texture_set = openntc.TextureSet(path)
                self.assertEqual(texture_set.generation, generation)
                numpy.testing.assert_array_equal(openntc.TextureSet(result.data).decode(), texture_set.decode())
                self.assertEqual([t.name for t in texture_set.textures], ["BaseColor", "Height"])
                self.assertEqual([t.color_space for t in texture_set.textures], ["sRGB", "Linear"])
                self.assertEqual([t.format for t in texture_set.textures], ["UNORM8", "UNORM16"])
                source = numpy.concatenate([images["BaseColor"].texels / 255, images["Height"][:, :, None] / 65535], axis=2)
                error = texture_set.decode() - source
                psnr = -10 * numpy.log10(numpy.mean(error.astype(numpy.float64) ** 2))
                # The encoder keeps sources in 16 bits: half a step of 1 / 65535 in each texel.
                self.assertAlmostEqual(psnr, result.psnr, delta=0.05)
                self.assertGreater(psnr, 15)
                self.assertEqual(result.steps, 400)

    def test_seeds_decide_and_threads_do_not(self):
        images = make_images()
        first = openntc.encode(images, steps=20, threads=1, mips=2)
        self.assertEqual(first.data, openntc.encode(images, steps=20, threads=2, mips=2).data)
        self.assertNotEqual(first.data, openntc.encode(images, steps=20, threads=1, mips=2, seed=2).data)

    def test_a_cancelled_run_is_resumed_to_the_same_bytes(self):
        images = make_images()
        whole = openntc.encode(images, steps=1000, mips=1, threads=1)
        calls = []

        def cancel(progress):
            calls.append(progress.step)
            return False

        part = openntc.encode(images, steps=1000, mips=1, threads=1, progress=cancel)
        self.assertTrue(part.cancelled)
        self.assertEqual(len(calls), 1)
        with self.assertRaisesRegex(ValueError, "cancelled"):
            part.save("never.ntc")
        self.assertEqual(openntc.encode(images, steps=1000, mips=1, threads=1, resume=part).data, whole.data)

    def test_exceptions_of_the_callback_come_out(self):
        def fail(progress):
            raise RuntimeError("from the callback")

        with self.assertRaisesRegex(RuntimeError, "from the callback"):
            openntc.encode(make_images(), steps=1000000, mips=1, progress=fail)

    def test_other_threads_run_while_training(self):
        seen = threading.Event()
        waiting = threading.Event()

        def other():
            waiting.wait()
            seen.set()

        thread = threading.Thread(target=other)
        thread.start()
        # The callback lets the other thread go on, which needs the lock that training does not hold.

        def end_when_seen(progress):
            waiting.set()
            return not seen.is_set()

        self.assertTrue(openntc.encode(make_images(), steps=1000000, mips=1, progress=end_when_seen).cancelled)
        thread.join()
        self.assertTrue(seen.is_set())

    def test_floats_are_linear_light(self):
        light = numpy.linspace(0, 4, 32 * 32, dtype=numpy.float32).reshape(32, 32)
        result = openntc.encode({"Light": light}, steps=400, bits_per_pixel=8, mips=1)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "light.ntc"
            result.save(path)
            decoded = openntc.TextureSet(path).texture("Light", linear=True)[:, :, 0]
        self.assertGreater(decoded.max(), 3)
        self.assertLess(numpy.abs(decoded - light).mean(), 0.2)

    def test_errors(self):
        flat = numpy.zeros((8, 8), numpy.uint8)
        for call, text in (
            (lambda: openntc.encode({}), "textures: none"),
            (lambda: openntc.encode({"a": flat, "b": numpy.zeros((4, 8), numpy.uint8)}), "b: 8 x 4: must be 8 x 8"),
            (lambda: openntc.encode({"a": numpy.zeros((8, 8, 17), numpy.uint8)}), "a: must be .* 16 channels"),
            (lambda: openntc.encode({"a": numpy.zeros((8, 8, 9), numpy.uint8), "b": numpy.zeros((8, 8, 9), numpy.uint8)}), "b: "),
            (lambda: openntc.encode({"a": numpy.zeros(8, numpy.uint8)}), "a: 1 dimensions"),
            (lambda: openntc.encode({"a": numpy.zeros((8, 8), numpy.int32)}), "a: int32: must be"),
            (lambda: openntc.encode({"a": openntc.Image(numpy.zeros((8, 8), numpy.float32), srgb=True)}), "a: floats"),
            (lambda: openntc.encode({"a": numpy.zeros((0, 8), numpy.uint8)}), "size"),
            (lambda: openntc.encode({"a": flat}, network="tiny"), "network: tiny: must be one of"),
            (lambda: openntc.encode({"a": flat}, effort="most"), "effort: most: must be one of"),
            (lambda: openntc.encode({"a": flat}, generation=2), "generation: 2"),
            (lambda: openntc.encode({"a": flat}, mask="b"), "mask: b: the textures are a"),
        ):
            with self.assertRaisesRegex(openntc.Error, text):
                call()

    def test_settings_are_checked_as_the_command_line_checks_them(self):
        flat = numpy.zeros((8, 8), numpy.uint8)
        infinite, nothing = float("inf"), float("nan")
        for settings, text in (
            ({"bits_per_pixel": -1}, "bits_per_pixel: -1: must be a number 0.01 to 1000"),
            ({"bits_per_pixel": "4"}, "bits_per_pixel: '4': must be a number 0.01 to 1000"),
            ({"bits_per_pixel": nothing}, "bits_per_pixel: nan: must be a number"),
            ({"seed": -1}, "seed: -1: must be a whole number 0 to 4294967295"),
            ({"seed": 2**32}, "seed: 4294967296: must be a whole number"),
            ({"seed": 1.5}, "seed: 1.5: must be a whole number"),
            ({"steps": -1}, "steps: -1: must be a whole number 1 to 1000000000"),
            ({"steps": 10**400}, "steps: 10+[.]+: must be a whole number"),
            ({"seconds": -1}, "seconds: -1: must be a number 0.001 to 1000000000"),
            ({"seconds": infinite}, "seconds: inf: must be a number"),
            ({"steps": 3, "seconds": 1}, "seconds: 1: not together with steps"),
            ({"steps": 3, "effort": "fast"}, "effort: 'fast': not together with steps or seconds"),
            ({"effort": 3}, "effort: 3: must be a string"),
            ({"threads": 257}, "threads: 257: must be a whole number 0 to 256"),
            ({"mips": 17}, "mips: 17: must be a whole number 1 to 16"),
            ({"mips": -1}, "mips: -1: must be"),
            ({"generation": "3"}, "generation: '3': must be"),
            ({"generation": 3, "network": "large"}, "network: 'large': generation 3 has one network"),
            ({"generation": 3, "network": "nope"}, "network: 'nope': generation 3 has one network"),
            ({"compress": True}, "compress: 1: only sets of generation 3"),
            ({"fp8": "no"}, "fp8: 'no': must be True or False"),
            ({"progress": 3}, "progress: int: must be a function"),
            ({"resume": "state"}, "resume: str: must be an EncodeResult"),
        ):
            with self.subTest(text), self.assertRaisesRegex(openntc.Error, text):
                openntc.encode({"a": flat}, **settings)
        openntc.encode({"a": flat}, steps=numpy.int64(2), bits_per_pixel=numpy.float32(4), fp8=numpy.bool_(False), mips=1)

    def test_textures_are_checked(self):
        flat = numpy.zeros((8, 8), numpy.uint8)
        for textures, text in (
            ([flat], "textures: list: must be a dictionary"),
            ({3: flat}, "textures: 3: names must be strings"),
            ({"a": openntc.Image(flat, weight=-1)}, "a: weight: -1: must be a number 0 to 1000000"),
            ({"a": openntc.Image(flat, weight=float("nan"))}, "a: weight: nan: must be"),
            ({"a": openntc.Image(flat, weight="1")}, "a: weight: '1': must be"),
            ({"a": openntc.Image(flat, weight=0)}, "weight: 0 for every texture: one must be above 0"),
            ({"a": openntc.Image(flat, srgb="yes")}, "a: srgb: 'yes': must be True or False"),
        ):
            with self.subTest(text), self.assertRaisesRegex(openntc.Error, text):
                openntc.encode(textures, steps=1)
        openntc.encode({"a": openntc.Image(flat, weight=0), "b": flat}, steps=1, mips=1)  # one may be left out
        with self.assertRaisesRegex(openntc.Error, "mask: a: 3 channels: must be a texture of 1"):
            openntc.encode({"a": numpy.zeros((8, 8, 3), numpy.uint8)}, mask="a", steps=1)
        for wrong in (float("nan"), float("inf"), -float("inf"), 1e300):
            light = numpy.zeros((4, 8))
            light[2, 5] = wrong
            with self.subTest(wrong), self.assertRaisesRegex(openntc.Error, "Light: -?(nan|inf) at column 5, row 2: must be finite"):
                openntc.encode({"Light": light}, steps=1)

    def test_what_the_callback_returns_is_checked(self):
        with self.assertRaisesRegex(openntc.Error, "progress: returned: 'go on': must be True or False"):
            openntc.encode(make_images(), steps=1000000, mips=1, progress=lambda progress: "go on")


class Stubs(unittest.TestCase):
    def test_stubs_name_what_there_is(self):
        stubs = (pathlib.Path(openntc.__file__).parent / "__init__.pyi").read_text()
        for name in openntc.__all__:
            self.assertRegex(stubs, rf"(class|def) {name}\b")
        for kind in (openntc.TextureSet, openntc.EncodeResult, openntc.Texture, openntc.Progress):
            for name in vars(kind):
                if not name.startswith("_"):
                    self.assertIn(f"def {name}(", stubs)


if __name__ == "__main__":
    unittest.main()
