// What parsers allocate, for files of a megabyte that need the most memory for their size.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "server/files/eulumdat.h"
#include "server/files/ies.h"
#include "server/files/ply.h"
#include "server/pbrt/load_pbrt.h"
#include "tests/fuzz/allocations.h"
#include "tests/fuzz/input_files.h"
#include "tests/server/files/limited_pool.h"

namespace lucerna::fuzz {
namespace {

constexpr std::size_t kBytes = std::size_t{1} << 20;
const std::string kWorld = "WorldBegin ";

/// As many units as fit in kBytes.
std::string filled(std::string_view unit) { return repeated(unit, kBytes / unit.size()); }

/// The same with %, which becomes another number each time.
std::string numbered(std::string_view unit) {
  std::string text;
  for (std::size_t i = 0; text.size() < kBytes; ++i)
    for (const char c : unit) text += c == '%' ? std::to_string(i) : std::string(1, c);
  return text;
}

std::string ply(std::string_view form, std::string_view elements, std::string_view body) {
  return fmt::format("ply\nformat {} 1.0\n{}end_header\n{}", form, elements, body);
}

/// Prints the peak over the size of the input.
void print(const char* parser, std::size_t peak, std::string_view text) {
  std::string begin(text.substr(0, 60));
  std::ranges::replace(begin, '\n', ' ');
  fmt::print("{} {:.1f} times: {}\n", parser, double(peak) / double(text.size()), begin);
}

TEST(Allocations, PlyHoldsAtMostEightTimesItsSize) {
  constexpr std::size_t kFaces = 50000;
  const std::string little = "binary_little_endian";
  const std::string vertices =
      "element vertex 4\nproperty char x\nproperty char y\nproperty char z\n";
  const std::string corners(12, '\0');
  const auto faces = [&](std::size_t count, const char* type) {
    return fmt::format("{}element face {}\nproperty list uchar {} vertex_indices\n", vertices,
                       count, type);
  };
  const std::string triangle{3, 0, 1, 2}, quad{4, 0, 1, 2, 3};
  const std::string wide_quad{4, 0, 0, 1, 0, 2, 0, 3, 0};
  const std::string large_triangle{3, 0, 0, 1, 0, 2, 0};
  for (const std::string& bytes : {
           ply(little,
               fmt::format("element vertex {}\nproperty char x\nproperty char y\n"
                           "property char z\nelement face 0\n"
                           "property list uchar int vertex_indices\n",
                           kFaces),
               std::string(3 * kFaces, '\0')),
           ply(little, faces(kFaces, "uchar"), corners + repeated(quad, kFaces)),
           ply(little, faces(kFaces, "uchar"), corners + repeated(triangle, kFaces - 1) + quad),
           ply(little, faces(2 * kFaces, "uchar"), corners + repeated(quad + triangle, kFaces)),
           ply(little, faces(kFaces, "ushort"), corners + repeated(wide_quad, kFaces)),
           ply(little, faces(kFaces, "ushort"),
               corners + repeated(large_triangle, kFaces / 2) + repeated(wide_quad, kFaces / 2)),
           ply("ascii", faces(kFaces, "uchar"),
               repeated("0 0 0\n", 4) + repeated("4 0 1 2 3\n", kFaces)),
           ply("ascii", "comment " + filled("a ") + "\n", ""),
           ply("ascii", filled("element a 0\n"), ""),
           ply("ascii", "element a 1\n" + filled("property char a\n"), ""),
           std::string("ply\nformat ") + filled("x") + " 1.0\n",
       }) {
    const AllocationBound bound("PLY", bytes.size());
    const auto mesh = parse_ply(bytes);
    const std::size_t peak = bound.peak_bytes();
    print("PLY", peak, bytes);
    EXPECT_LE(peak, AllocationBound::kFactor * bytes.size() + AllocationBound::kFixedBytes)
        << bytes.substr(0, 200) << " " << mesh.status();
  }
}

TEST(Allocations, PhotometricParsersHoldAtMostEightTimesTheSizeBeyondTheWeb) {
  const std::string ies = "IESNA:LM-63-2002\nTILT=NONE\n1 1 1 {} 1 2 0 0 0\n1 1 1\n";
  const auto grid = [](int count, double most) {
    std::string text;
    for (int i = 0; i <= count; ++i) text += fmt::format("{:g} ", most * i / count);
    return text + "\n";
  };
  const std::string lines = filled("\n");
  std::string ldt = "\n\n4\n400\n\n1001\n";
  ldt += repeated("\n", 17) + "1\n\n1\n1\n\n1\n\n\n\n" + repeated("\n", 10);
  for (int i = 0; i < 400; ++i) ldt += fmt::format("{:g}\n", 0.9 * i);
  for (int i = 0; i < 1001; ++i) ldt += fmt::format("{:g}\n", 0.09 * i);
  ldt += repeated("1\n", 101 * 1001);
  for (const std::string& text : {fmt::format(fmt::runtime(ies), "1001 401") + grid(1000, 90) +
                                      grid(400, 90) + repeated("1 ", 1001 * 401),
                                  fmt::format(fmt::runtime(ies), "1001 401") + lines,
                                  "IESNA:LM-63-2002\n" + lines, lines, ldt}) {
    for (const auto& parse : {&parse_ies, &parse_eulumdat}) {
      const AllocationBound bound("web", text.size());
      const auto file = parse(text, "file");
      const std::size_t beyond = bound.peak_beyond_result_bytes(), peak = bound.peak_bytes();
      print("web, beyond it", beyond, text);
      print("web", peak, text);
      EXPECT_LE(beyond, AllocationBound::kFactor * text.size() + AllocationBound::kFixedBytes)
          << text.substr(0, 200) << " " << file.status();
    }
  }
  EXPECT_TRUE(parse_eulumdat(ldt, "file").ok()) << parse_eulumdat(ldt, "file").status();
}

/// Loads `text` and requires that the peak is at most 8 times its size plus `fixed` bytes.  With
/// `counts_lists`, what the memory budget counts is added.
void check_pbrt(const std::string& text, std::size_t fixed = AllocationBound::kFixedBytes,
                bool counts_lists = false) {
  testing::LimitedPool pool;
  LoadBudget budget(&pool);
  AssetReader assets(std::make_unique<InputFiles>(text, "scene.pbrt"), {.budget = &budget});
  const AllocationBound bound(".pbrt", text.size());
  const auto scene = load_pbrt(assets, "scene.pbrt", {}, {.budget = &budget});
  const std::size_t peak = bound.peak_bytes();
  print(".pbrt", peak, std::string_view(text).substr(text.starts_with(kWorld) ? kWorld.size() : 0));
  EXPECT_LE(peak, AllocationBound::kFactor * text.size() + fixed + (counts_lists ? pool.most() : 0))
      << text.substr(0, 200) << " " << scene.status() << " counted " << pool.most();
}

TEST(Allocations, PbrtWithOpenBlocksHoldsAtMostEightTimesItsSizeAndTwoMegabytes) {
  const std::string blocks = repeated("AttributeBegin ", 255);
  std::string attributes;
  for (const char* target : {"shape", "light", "material", "texture", "medium"})
    for (int i = 0; i < 64; ++i)
      attributes += fmt::format("Attribute\"{}\"\"float a{}\"1 ", target, i);
  for (const std::string& text :
       {kWorld + blocks + repeated("AttributeEnd ", 255), kWorld + filled("AttributeBegin "),
        kWorld + attributes + blocks, kWorld + numbered("Attribute\"shape\"\"float a%\"1 ")})
    check_pbrt(text, kPbrtFixedBytes);
}

TEST(Allocations, PbrtHoldsAtMostEightTimesItsSize) {
  const std::string triangle = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 ";
  const std::string corners = "] \"point3 P\" [0 0 0 1 0 0 1 1 0 ";
  for (const std::string& text : {
           kWorld + filled("Attribute\"shape\"\"float a\"1 "),
           kWorld + numbered("Attribute\"shape\"\"float a%\"1 "),
           kWorld + filled("AreaLightSource\"diffuse\""),
           kWorld + numbered("CoordinateSystem\"%\""),
           kWorld + numbered("CoordSysTransform\"%\""),
           kWorld + filled("Material\"diffuse\""),
           kWorld + filled("Material\"diffuse\"\"float a\"1"),
           kWorld + filled("NamedMaterial\"a\""),
           kWorld + numbered("Texture\"%\"\"float\"\"constant\""),
           kWorld + numbered("Texture\"%\"\"float\"\"wrinkled\""),
           numbered("MakeNamedMedium\"%\"\"string type\"\"homogeneous\""),
           numbered("MediumInterface\"%\""),
           numbered("Option\"%\" 1 "),
           filled("Option\"\" 1 "),
           kWorld + numbered("ObjectBegin\"%\"ObjectEnd "),
           kWorld + "Shape \"sphere\" " + numbered("\"float %\"1"),
           kWorld + "Shape \"sphere\" \"float a\" [" + filled("1 ") + "]",
           kWorld + "Shape \"sphere\" \"float a\" [" + repeated("1 ", 600000) + "]",
           kWorld + "Shape \"sphere\" \"float a\" [" + filled("1#\n ") + "]",
           kWorld + "Shape \"sphere\" \"string a\" [" + filled("\"\"") + "]",
           kWorld + "Shape \"sphere\" \"bool a\" [" + filled("\"true\"") + "]",
           kWorld + "Shape \"trianglemesh\" \"point3 P\" [" + filled("0 0 0 ") + "0 ]",
           kWorld + triangle + filled("0 1 2 ") + corners + "]",
           kWorld + triangle + corners + filled("0 0 0 ") + "]",
           kWorld + triangle + corners + repeated("0 0 0 ", 80000) +
               "] \"normal N\" [0 0 1 0 0 1 0 0 1 " + repeated("0 0 1 ", 80000) +
               "] \"point2 uv\" [0 0 1 0 1 1 " + repeated("0 0 ", 80000) + "]",
           kWorld +
               "Shape \"curve\" \"integer degree\" 2 \"string basis\" \"bspline\" \"point3 P\" [" +
               filled("0 0 0 1 0 0 ") + "]",
           kWorld + "LightSource \"point\" \"spectrum I\" [" + numbered("% 1 ") + "]",
           kWorld + filled("Scale 1 1 1 "),
           kWorld + filled("a"),
           kWorld + "Shape \"" + filled("\\n") + "\"",
           "#" + filled("a"),
       })
    check_pbrt(text);
}

// Directives with as many digits as programs write.
TEST(Allocations, PbrtOfOrdinaryDirectivesHoldsAtMostEightTimesItsSize) {
  const std::string move = "AttributeBegin\nTranslate 1.25 %.5 -0.75\n";
  for (const std::string& text : {
           numbered(move + "Shape \"sphere\" \"float radius\" 0.125\nAttributeEnd\n"),
           numbered("Material \"diffuse\" \"rgb reflectance\" [0.8 0.75 0.%]\n" + move +
                    "Shape \"cylinder\" \"float radius\" 0.125\nAttributeEnd\n"),
           numbered(move + "AreaLightSource \"diffuse\" \"rgb L\" [10 8 %]\n"
                           "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n"
                           "  \"point3 P\" [0 0 0 1.5 0 0 1.5 1.5 0 0 1.5 0]\nAttributeEnd\n"),
           numbered("Shape \"curve\" \"string type\" \"cylinder\" \"float width\" 0.0025\n"
                    "  \"point3 P\" [0.25 % 0 0.5 % 1.25 0.75 % 1.5 0.5 % 1.75]\n"),
           numbered("MakeNamedMaterial \"wood.%\" \"string type\" \"coateddiffuse\"\n"
                    "  \"rgb reflectance\" [0.8 0.75 0.5] \"float roughness\" 0.125\n"),
           numbered("LightSource \"point\" \"point3 from\" [1.2345 %.5432 2.4681]\n"
                    "  \"rgb I\" [12.345 11.234 10.123]\n"),
           "WorldBegin ObjectBegin \"tree\" Shape \"sphere\" ObjectEnd\n" +
               numbered("AttributeBegin\nTransform [0.5 0 0 0 0 0.5 0 0 0 0 0.5 0 1.25 % -0.75 1]\n"
                        "ObjectInstance \"tree\"\nAttributeEnd\n"),
       })
    check_pbrt(text.starts_with("WorldBegin") ? text : kWorld + text);
}

TEST(Allocations, PbrtCountsAListThatGoesOnBehindAnIncludedFile) {
  const std::string text = "WorldBegin Include \"b.pbrt\" " + filled("1 ") +
                           "]\n#FILE b.pbrt\nShape \"sphere\" \"float a\" [";
  testing::LimitedPool pool;
  LoadBudget budget(&pool);
  AssetReader assets(std::make_unique<InputFiles>(text, "scene.pbrt"), {.budget = &budget});
  const auto scene = load_pbrt(assets, "scene.pbrt", {}, {.budget = &budget});
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_GE(pool.most(), kBytes / 2 * sizeof(double));
}

// Many short directives: each becomes an object that is larger than its text.
TEST(Allocations, PbrtOfTheShortestDirectivesHoldsEightTimesItsSizeAndWhatTheBudgetCounts) {
  for (const std::string& text : {
           filled("Shape \"sphere\" "),
           filled("Shape\"disk\""),
           "ObjectBegin \"a\" " + filled("Shape\"disk\"") + "ObjectEnd",
           "ActiveTransform EndTime Translate 1 0 0 ActiveTransform All " + filled("Shape\"disk\""),
           "ActiveTransform EndTime " +
               numbered(
                   "Translate 1 % 0 ActiveTransform All Shape\"disk\"ActiveTransform EndTime "),
           "ActiveTransform StartTime " + numbered("Scale 2 1 1 CoordinateSystem\"%\""),
           "AreaLightSource\"diffuse\"\"string name\"\"" + repeated("a", 256) + "\"" +
               filled("Shape\"disk\""),
           filled("LightSource \"point\" "),
           "AreaLightSource\"diffuse\"" + filled("Shape\"disk\""),
           "ObjectBegin\"a\"ObjectEnd " + filled("ObjectInstance\"a\""),
           filled("ObjectInstance\"a\""),
           filled("Scale 2 1 1 CoordinateSystem\"a\""),
           numbered("MakeNamedMaterial\"%\"\"string type\"\"diffuse\""),
           numbered("MakeNamedMaterial\"%\"\"string type\"\"mix\"\"float a\"1\"float b\"1 "),
           numbered("NamedMaterial\"%\""),
       })
    check_pbrt(kWorld + text, AllocationBound::kFixedBytes, true);
}

}  // namespace
}  // namespace lucerna::fuzz
