#include "renderd/scene/file_order.h"

#include <gtest/gtest.h>

#include <cmath>

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

v1::FileMark mark(std::uint32_t width, std::uint32_t height) {
  v1::FileMark mark;
  mark.mutable_mark()->set_kind(v1::Mark::TEXT);
  mark.mutable_label()->set_width(width);
  mark.mutable_label()->set_height(height);
  mark.mutable_label()->set_scale(1);
  return mark;
}

TEST(FileMarkOrder, LimitsMarksAndTheirTexts) {
  std::vector<v1::FileMark> marks;
  for (int i = 0; i < 16; ++i) ASSERT_TRUE(note_file_mark(marks, mark(1024, 1024)));
  EXPECT_FALSE(note_file_mark(marks, mark(1, 1))) << "all texts together are too large";
  marks.clear();
  for (std::size_t i = 0; i < kMostFileMarks; ++i) ASSERT_TRUE(note_file_mark(marks, mark(9, 9)));
  EXPECT_FALSE(note_file_mark(marks, mark(9, 9)));
  marks.clear();
  EXPECT_FALSE(note_file_mark(marks, mark(1025, 1024)));
  EXPECT_FALSE(note_file_mark(marks, mark(0x10000, 0x10000)));
  EXPECT_FALSE(note_file_mark(marks, mark(0, 9)));
  for (const auto& spoil : std::vector<void (*)(v1::FileMark&)>{
           [](v1::FileMark& one) { one.mutable_mark()->set_kind(v1::Mark::KIND_UNSPECIFIED); },
           [](v1::FileMark& one) { one.mutable_mark()->set_colour(8); },
           [](v1::FileMark& one) { one.mutable_mark()->set_radius(-1); },
           [](v1::FileMark& one) { one.mutable_label()->set_scale(0); },
           [](v1::FileMark& one) { one.mutable_label()->set_scale(NAN); },
           [](v1::FileMark& one) { one.mutable_label()->set_margin(5); },
           [](v1::FileMark& one) { one.mutable_label()->set_baseline(10); }}) {
    v1::FileMark broken = mark(9, 9);
    spoil(broken);
    EXPECT_FALSE(note_file_mark(marks, broken)) << broken.ShortDebugString();
  }
  EXPECT_TRUE(marks.empty());
  v1::FileRequest request;
  EXPECT_TRUE(check_mark_unit(request));
  for (const double unit : {-1.0, 0.01, 101.0}) {
    request.set_mark_unit(unit);
    EXPECT_FALSE(check_mark_unit(request));
  }
}

}  // namespace
}  // namespace diaphane::render
