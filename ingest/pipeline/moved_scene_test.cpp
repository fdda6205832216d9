#include "ingest/pipeline/moved_scene.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace diaphane::ingest {
namespace {

using nlohmann::json;

TEST(MovedScene, MovesWorldPositionsAndKeepsTheLook) {
  const std::string before = R"({
    "transferFunction": {"channels": [{"name": "bone", "opacity": [{"value": 100}, {"value": 300, "opacity": 1}]}],
                         "extinctionPerMm": 2},
    "camera": {"eye": {"y": -500}, "target": {"x": 1, "y": 2, "z": 3}, "up": {"z": 1}, "verticalFovDegrees": 30,
               "focalDistance": 77},
    "lights": [{"rectangle": {"corner": {"x": 10}, "u": {"x": 5}, "v": {"y": 5}, "radiance": {"r": 1}}},
               {"cameraLocked": true, "disk": {"centre": {"x": 10}, "normal": {"z": -1}, "radius": 4}},
               {"sphere": {"centre": {"z": 9}, "radius": 3}}, {"box": {"corner": {"y": 1}}},
               {"environment": {"radiance": {"g": 1}}}],
    "clip": {"boxLow": {"x": -9, "y": -9, "z": -9}, "boxHigh": {"x": 9, "y": 9, "z": 9},
             "planes": [{"point": {"z": 4}, "normal": {"z": 1}}]},
    "slices": {"sagittal": {"shown": true, "position": 1}, "axial": {"position": -1}},
    "highlight": {"centre": {"x": 2}, "radius": 8}, "bounces": 2})";
  const auto moved = moved_scene(before, {1, 20, 300});
  ASSERT_TRUE(moved.has_value());
  const json now = json::parse(*moved), old = json::parse(before);
  EXPECT_EQ(now["camera"]["eye"], (json{{"x", -1}, {"y", -520}, {"z", -300}}));
  EXPECT_EQ(now["camera"]["target"], (json{{"y", -18}, {"z", -297}}));
  EXPECT_EQ(now["camera"]["up"], old["camera"]["up"]);
  EXPECT_EQ(now["camera"]["focalDistance"], 77);
  EXPECT_EQ(now["transferFunction"]["extinctionPerMm"], 2);
  EXPECT_EQ(now["lights"][0]["rectangle"]["corner"], (json{{"x", 9}, {"y", -20}, {"z", -300}}));
  EXPECT_EQ(now["lights"][0]["rectangle"]["u"], old["lights"][0]["rectangle"]["u"]);
  EXPECT_EQ(now["lights"][1]["disk"]["centre"], old["lights"][1]["disk"]["centre"]);
  EXPECT_EQ(now["lights"][2]["sphere"]["centre"], (json{{"x", -1}, {"y", -20}, {"z", -291}}));
  EXPECT_EQ(now["lights"][3]["box"]["corner"], (json{{"x", -1}, {"y", -19}, {"z", -300}}));
  EXPECT_EQ(now["clip"]["boxLow"], (json{{"x", -10}, {"y", -29}, {"z", -309}}));
  EXPECT_EQ(now["clip"]["boxHigh"], (json{{"x", 8}, {"y", -11}, {"z", -291}}));
  EXPECT_EQ(now["clip"]["planes"][0]["point"], (json{{"x", -1}, {"y", -20}, {"z", -296}}));
  EXPECT_EQ(now["highlight"],
            (json{{"centre", {{"x", 1}, {"y", -20}, {"z", -300}}}, {"radius", 8}}));
  EXPECT_FALSE(now["slices"]["sagittal"].contains("position"));  // 1 - 1
  EXPECT_EQ(now["slices"]["axial"]["position"], -301);
  const auto back = moved_scene(*moved, {-1, -20, -300});
  EXPECT_EQ(json::parse(*back)["clip"], old["clip"]);
}

TEST(MovedTour, MovesPlacesAndNoDirections) {
  const std::string before =
      R"({"views":[{"eye":[1,-520,5],"target":[0,2,3],"up":[0,0,1]},{"eye":[9,8,7],"target":[6,5,4],"up":[1,0,0]}],)"
      R"("participants":3,"title":{"en":"Views"}})";
  const auto moved = moved_tour(before, {1, -20, 300});
  ASSERT_TRUE(moved.has_value());
  const json expected{{"views",
                       {{{"eye", {0, -500, -295}}, {"target", {-1, 22, -297}}, {"up", {0, 0, 1}}},
                        {{"eye", {8, 28, -293}}, {"target", {5, 25, -296}}, {"up", {1, 0, 0}}}}},
                      {"participants", 3},
                      {"title", {{"en", "Views"}}}};
  EXPECT_EQ(json::parse(*moved), expected);
}

TEST(MovedTour, RefusesInvalidTour) {
  for (const char* wrong : {"", "{}", R"({"views":[{"eye":[1,2]}]})", R"({"views":[{"eye":1}]})"}) {
    EXPECT_FALSE(moved_tour(wrong, {}));
  }
}

TEST(MovedScene, RefusesInvalidScene) {
  EXPECT_FALSE(moved_scene("{\"nothing\": 1}", {}));
  EXPECT_FALSE(moved_scene("", {}));
}

}  // namespace
}  // namespace diaphane::ingest
