#include "renderd/cli/labels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "renderd/cli/options.h"

namespace diaphane::render::cli {
namespace {

volume::LabelSet example() {
  volume::LabelSet set;
  set.table = {{3, "Liver", {255, 0, 0}}, {5, "Vein", {0, 255, 0}}, {8, "Vein", {0, 0, 255}}};
  set.labels = {{2, 2, 2}, {0, 1, 1, 1, 2, 2, 3, 0}};
  return set;
}

TEST(LabelOptions, HaveColourOpacityAndSolo) {
  const auto full = parse_label("Left = right=#10ff00,0.25,solo");
  ASSERT_TRUE(full);
  EXPECT_EQ(full->name, "Left = right");
  EXPECT_EQ(full->colour, (std::array<std::uint8_t, 3>{16, 255, 0}));
  EXPECT_EQ(full->opacity, 0.25);
  EXPECT_TRUE(full->solo);
  EXPECT_EQ(parse_label("7=0")->opacity, 0);
  for (const char* wrong : {"", "Liver", "Liver=", "=0.5", "Liver=1.1", "Liver=-1", "Liver=nan",
                            "Liver=#12345", "Liver=#gg0000", "Liver=0.5,", "Liver=blue"}) {
    EXPECT_FALSE(parse_label(wrong)) << wrong;
  }
}

TEST(LabelOptions, TakeTheColoursOfTheFileAndThenTheirOwn) {
  diaphane::v1::Scene scene;
  scene.add_labels()->set_number(5);
  scene.mutable_labels(0)->set_opacity(0.5);
  ASSERT_TRUE(
      show_labels(example(), {*parse_label("Liver=#000000,0.75"), *parse_label("8=solo")}, scene));
  ASSERT_EQ(scene.labels_size(), 3);
  ASSERT_TRUE(show_labels(example(), {*parse_label("0=0.5")}, scene)) << "all other matter";
  ASSERT_EQ(scene.labels_size(), 4);
  EXPECT_EQ(scene.labels(3).number(), 0u);
  EXPECT_FALSE(scene.labels(0).has_colour()) << "as the scene says";
  EXPECT_EQ(scene.labels(0).opacity(), 0.5);
  EXPECT_EQ(scene.labels(1).number(), 3u);
  EXPECT_EQ(scene.labels(1).colour().r(), 0);
  EXPECT_EQ(scene.labels(1).opacity(), 0.75);
  EXPECT_EQ(scene.labels(2).colour().b(), 1);
  EXPECT_TRUE(scene.labels(2).solo());
  EXPECT_FALSE(scene.labels(2).has_opacity());
}

TEST(LabelOptions, UnknownAndAmbiguousNamesAreRefused) {
  diaphane::v1::Scene scene;
  const auto unknown = show_labels(example(), {*parse_label("Spleen=0")}, scene);
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("none called 'Spleen'"), std::string::npos);
  const auto twice = show_labels(example(), {*parse_label("Vein=0")}, scene);
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().message.find("several labels are called 'Vein'"), std::string::npos);
}

TEST(LabelOptions, ListsLabelsWithTheirVolumes) {
  volume::Header header;
  header.size = {2, 2, 2};
  header.spacing = {10, 10, 5};
  std::ostringstream out;
  list_labels(example(), header, out);
  EXPECT_EQ(out.str(),
            "3\t#ff0000\t1.5 ml\tLiver\n5\t#00ff00\t1.0 ml\tVein\n8\t#0000ff\t0.5 ml\tVein\n");
}

TEST(LabelOptions, ShowFoundPartsByNameAndLeaveTheOthersAsTheyAre) {
  volume::LabelSet set = example();
  set.table[1] = {0xFFFFFF05, "", {236, 226, 200}};
  diaphane::v1::Scene scene;
  ASSERT_TRUE(show_labels(set, {}, scene));
  EXPECT_EQ(scene.labels_size(), 2) << "nobody has marked the bone, so it gets no colour";
  ASSERT_TRUE(show_labels(set, {*parse_label("bone=solo")}, scene));
  ASSERT_EQ(scene.labels_size(), 3);
  EXPECT_EQ(scene.labels(2).number(), 0xFFFFFF05u);
  EXPECT_TRUE(scene.labels(2).solo());
  std::ostringstream out;
  list_labels(set, {}, out);
  EXPECT_NE(out.str().find("\tbone\n"), std::string::npos) << out.str();
}

TEST(LabelOptions, NeedNoFileOfLabels) {
  const char* alone[] = {"diaphane-render", "in",    "--preset", "skin",
                         "--out",           "a.png", "--label",  "bone=0"};
  EXPECT_TRUE(std::holds_alternative<Options>(parse(8, alone)));
  const char* twice[] = {"diaphane-render", "in",      "--preset", "skin",
                         "--out",           "a.ppm",   "--labels", "l.nii",
                         "--label",         "Liver=0", "--label",  "Vein=#ff0000"};
  const auto parsed = parse(12, twice);
  ASSERT_TRUE(std::holds_alternative<Options>(parsed)) << std::get<EarlyExit>(parsed).text;
  EXPECT_EQ(std::get<Options>(parsed).labels.size(), 2u);
  const char* listed[] = {"diaphane-render", "in", "--list-labels", "--labels", "l.nii"};
  EXPECT_TRUE(std::holds_alternative<Options>(parse(5, listed)));
  EXPECT_TRUE(std::holds_alternative<Options>(parse(3, listed)));
}

}  // namespace
}  // namespace diaphane::render::cli
