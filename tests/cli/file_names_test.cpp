// SPDX-License-Identifier: MIT
// File names from the names of textures and materials.
#include "FileNames.h"

#include <doctest/doctest.h>

#include <string>

using namespace openntc;

TEST_CASE("hostile texture names become safe, distinct file names") {
    tool::FileNames names;
    CHECK(names.Add("BaseColor") == "BaseColor");
    CHECK(names.Add("basecolor") == "basecolor_2");
    CHECK(names.Add("BaseColor") == "BaseColor_3");
    CHECK(names.Add("../../etc/passwd") == "___.._etc_passwd");
    CHECK(names.Add("") == "texture");
    CHECK(names.Add("..") == "__");
    CHECK(names.Add(".hidden") == "_hidden");
    CHECK(names.Add("a\\b:c*d") == "a_b_c_d");
    CHECK(names.Add("gr\xC3\xBC"
                    "n") == "gr\xC3\xBCn");
    CHECK(names.Add("x\n\x1b[0m") == "x___0m");
    CHECK(names.Add(std::string(5000, 'z')).size() == 100);
    CHECK(names.Add(std::string(5000, 'z')).size() == 102);
    CHECK(names.Add(std::string_view("nul\0byte", 8)) == "nul_byte");
}

TEST_CASE("file names: other scripts stay, what is hostile or reserved does not") {
    tool::FileNames names;
    CHECK(names.Add("Gew\u00F6lbe t\u00FCr_\u8272") == "Gew\u00F6lbe_t\u00FCr_\u8272");
    CHECK(names.Add("\u56FE\u50CF") == "\u56FE\u50CF");
    CHECK(names.Add("\u7EB9\u7406") == "\u7EB9\u7406");
    // Direction overrides, invisible characters, full-width separators, C1 controls, private and unassigned
    // ends.
    CHECK(names.Add("a\u202Egnp") == "a_gnp");
    CHECK(names.Add("a\u200Bb") == "a_b");
    CHECK(names.Add("a\u2066b\u2069") == "a_b_");
    CHECK(names.Add("c\uFF0Fd") == "c_d");
    CHECK(names.Add("c\u0085e") == "c_e");
    CHECK(names.Add("c\u061Cf") == "c_f");
    CHECK(names.Add("c\uFEFFg") == "c_g");
    CHECK(names.Add("c\uE000h") == "c_h");
    CHECK(names.Add("c\U000E0041i") == "c_i");
    // No UTF-8: overlong, surrogate, cut, stray; one '_' a run.
    CHECK(names.Add("d\xC0\xAF") == "d_");
    CHECK(names.Add("e\xED\xA0\x80x") == "e_x");
    CHECK(names.Add("f\xE2\x82") == "f_");
    CHECK(names.Add("g\xFF\xFEh") == "g_h");
    // Devices of Windows, whatever follows the dot; names that only begin so are fine.
    CHECK(names.Add("CON") == "CON_");
    CHECK(names.Add("nul") == "nul_");
    CHECK(names.Add("aux.txt") == "aux_.txt");
    CHECK(names.Add("Com1") == "Com1_");
    CHECK(names.Add("LPT9.a.b") == "LPT9_.a.b");
    CHECK(names.Add("console") == "console");
    CHECK(names.Add("com10") == "com10");
    CHECK(names.Add("end.") == "end_");
    CHECK(names.Add("end ") == "end__2");
    // Case and accents do not tell names apart on every system.
    CHECK(names.Add("\u00C4rger") == "\u00C4rger");
    CHECK(names.Add("\u00E4rger") == "\u00E4rger_2");
    CHECK(names.Add("a\u0308rger") == "a\u0308rger_3");
    CHECK(names.Add("\u0416") == "\u0416");
    CHECK(names.Add("\u0436") == "\u0436_2");
    CHECK(names.Add("\u03A3") == "\u03A3");
    CHECK(names.Add("\u03C3") == "\u03C3_2");
    // Cut between characters.
    std::string many;
    for (int i = 0; i < 60; ++i)
        many += "\u8272";
    CHECK(names.Add(many) == many.substr(0, 99));
}
