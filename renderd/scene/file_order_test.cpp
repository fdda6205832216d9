#include "renderd/scene/file_order.h"

#include <gtest/gtest.h>

#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;

v1::KeyView view(std::uint32_t index, double x) {
  v1::KeyView view;
  view.set_index(index);
  v1::Scene& scene = *view.mutable_scene();
  test::add_channel(*scene.mutable_transfer_function(), {{100, 0.1}, {1000, 1}});
  scene.mutable_transfer_function()->set_extinction_per_mm(1);
  test::add_lamp(scene, 0, 0, 400, 100, 5);
  test::set_camera(scene, x, 300, 0, 40);
  scene.mutable_phase();
  scene.mutable_display()->mutable_background();
  return view;
}

struct FileOrder : testing::Test {
  void SetUp() override {
    ASSERT_TRUE(note_key_view(keys, view(0, 1)));
    ASSERT_TRUE(note_key_view(keys, view(1, 2)));
  }
  std::vector<v1::Scene> keys;
};

TEST_F(FileOrder, FirstViewStartsANewList) {
  ASSERT_TRUE(note_key_view(keys, view(0, 3)));
  ASSERT_EQ(keys.size(), 1U);
  EXPECT_EQ(keys[0].camera().eye().x(), 3);
}

TEST_F(FileOrder, RejectedViewDoesNotChangeTheList) {
  for (const std::uint32_t index : {0U, 2U}) {
    v1::KeyView broken = view(index, 3);
    broken.mutable_scene()->clear_camera();
    EXPECT_FALSE(note_key_view(keys, broken));
  }
  for (const std::uint32_t index : {1U, 3U, 16U}) EXPECT_FALSE(note_key_view(keys, view(index, 3)));
  ASSERT_EQ(keys.size(), 2U);
  EXPECT_EQ(keys[0].camera().eye().x(), 1);
  EXPECT_EQ(keys[1].camera().eye().x(), 2);
}

}  // namespace
}  // namespace diaphane::render
