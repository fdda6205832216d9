#include "renderd/encode/file_marks.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;
using Pixel = std::array<int, 3>;

constexpr Pixel kBlack{0, 0, 0}, kOrange{0xff, 0xb4, 0x54}, kDark{0x14, 0x18, 0x1d};

/// Looks along y: x to the right and z up, with 1 mm per pixel in 64 rows.
v1::Scene scene_from_the_front() {
  v1::Scene scene;
  v1::Camera& camera = *scene.mutable_camera();
  camera.mutable_eye()->set_y(-100);
  camera.mutable_target();
  camera.mutable_up()->set_z(1);
  camera.set_orthographic_height(64);
  return scene;
}

v1::FileMark mark_at(v1::Mark::Kind kind, double x, double z) {
  v1::FileMark mark;
  mark.mutable_mark()->set_kind(kind);
  mark.mutable_mark()->mutable_place()->set_x(x);
  mark.mutable_mark()->mutable_place()->set_z(z);
  return mark;
}

void label(v1::FileMark& mark, const std::string& outline, const std::string& letters) {
  const std::string both = outline + letters;
  uLongf length = compressBound(both.size());
  std::string coded(length, '\0');
  compress(reinterpret_cast<Bytef*>(coded.data()), &length,
           reinterpret_cast<const Bytef*>(both.data()), both.size());
  coded.resize(length);
  mark.mutable_label()->set_coverage(coded);
}

struct FileMarksTest : testing::Test {
  FileMarks made(std::vector<v1::FileMark> marks, double unit = 1) {
    auto result =
        FileMarks::make(std::move(marks), unit,
                        [this](const v1::Scene&, Canvas canvas, const std::vector<Double3>& at) {
                          asked = canvas;
                          return std::vector<bool>(at.size(), hidden);
                        });
    EXPECT_TRUE(result);
    return std::move(*result);
  }
  PictureRgb8 drawn(const FileMarks& marks, Canvas canvas = {64, 64}) {
    PictureRgb8 picture{canvas, std::vector<std::uint8_t>(3 * canvas.width * canvas.height)};
    marks.draw(picture, scene);
    return picture;
  }
  static Pixel at(const PictureRgb8& picture, std::uint32_t x, std::uint32_t y) {
    const auto* one = &picture.pixels[3 * (picture.size.width * y + x)];
    return {one[0], one[1], one[2]};
  }

  v1::Scene scene = scene_from_the_front();
  bool hidden = false;
  Canvas asked;
};

TEST_F(FileMarksTest, DrawsAnArrowFromItsTailToItsPlace) {
  v1::FileMark arrow = mark_at(v1::Mark::ARROW, -16, 0);
  arrow.mutable_mark()->mutable_tail()->set_x(16);
  const PictureRgb8 picture = drawn(made({arrow}, 2));
  EXPECT_EQ(at(picture, 45, 32), kOrange);
  EXPECT_EQ(at(picture, 45, 36), kDark) << "the outline";
  EXPECT_EQ(at(picture, 45, 50), kBlack);
  EXPECT_EQ(at(picture, 24, 35), kOrange) << "the head is wider than the line";
  EXPECT_EQ(at(picture, 8, 32), kBlack) << "nothing lies beyond the tip";
}

TEST_F(FileMarksTest, DrawsHiddenMarksFaintAndDashed) {
  v1::FileMark arrow = mark_at(v1::Mark::ARROW, -24, 0);
  arrow.mutable_mark()->mutable_tail()->set_x(24);
  hidden = true;
  const PictureRgb8 picture = drawn(made({arrow}, 2));
  int gaps = 0, dashes = 0;
  for (std::uint32_t x = 36; x < 56; ++x) {
    const int red = at(picture, x, 32)[0];
    EXPECT_LT(red, 0xa0) << "half of it shines through";
    gaps += red < 0x18 ? 1 : 0;
    dashes += red > 0x60 ? 1 : 0;
  }
  EXPECT_GT(gaps, 3);
  EXPECT_GT(dashes, 6);
}

TEST_F(FileMarksTest, DrawsACircleAsTheOutlineOfASphere) {
  v1::FileMark circle = mark_at(v1::Mark::CIRCLE, 4, 2);
  circle.mutable_mark()->set_radius(12);
  const PictureRgb8 picture = drawn(made({circle}));
  for (const auto& [x, y] : {std::pair{24, 30}, {47, 30}, {36, 18}, {36, 41}}) {
    EXPECT_EQ(at(picture, x, y), kOrange) << x << " " << y;
  }
  EXPECT_EQ(at(picture, 36, 30), kBlack);
}

TEST_F(FileMarksTest, DrawsARulerBetweenItsEndsAndAnAngleWithTwoSides) {
  v1::FileMark ruler = mark_at(v1::Mark::RULER, -16, 0);
  ruler.mutable_mark()->mutable_tail()->set_x(16);
  const PictureRgb8 line = drawn(made({ruler}));
  for (const int x : {16, 32, 47}) EXPECT_EQ(at(line, x, 32), kOrange) << x;
  EXPECT_EQ(at(line, 16, 33), kOrange) << "a dot at its end, wider than the line";
  v1::FileMark angle = mark_at(v1::Mark::ANGLE, -16, -16);
  angle.mutable_mark()->mutable_tail()->set_x(16);
  angle.mutable_mark()->mutable_tail()->set_z(-16);
  angle.mutable_mark()->mutable_end()->set_x(-16);
  angle.mutable_mark()->mutable_end()->set_z(16);
  const PictureRgb8 sides = drawn(made({angle}));
  EXPECT_EQ(at(sides, 32, 48), kOrange);
  EXPECT_EQ(at(sides, 16, 32), kOrange);
  EXPECT_EQ(at(sides, 32, 32), kBlack) << "no third side";
}

TEST_F(FileMarksTest, PrintsTheTextOfThePageBesideItsPoint) {
  v1::FileMark text = mark_at(v1::Mark::TEXT, 0, 0);
  v1::FileMark::Label& given = *text.mutable_label();
  given.set_width(4);
  given.set_height(2);
  given.set_scale(2);
  given.set_margin(1);
  given.set_baseline(2);
  const std::string all(8, '\xff');
  std::string letters(8, '\0');
  letters[1] = letters[2] = letters[5] = letters[6] = '\xff';
  label(text, all, letters);
  const PictureRgb8 picture = drawn(made({text}));
  EXPECT_EQ(at(picture, 32, 32), kOrange) << "the point";
  // The text has no room on the right: it ends 10 pixels left of the point and 5 below it.
  EXPECT_EQ(at(picture, 20, 35), kOrange);
  EXPECT_NEAR(at(picture, 23, 35)[0], kDark[0], 8);
  EXPECT_NEAR(at(picture, 23, 35)[2], kDark[2], 8);
  EXPECT_EQ(at(picture, 20, 38), kBlack);
}

TEST_F(FileMarksTest, BandsAreThoseOfTheWholePicture) {
  v1::FileMark arrow = mark_at(v1::Mark::ARROW, -16, -14);
  arrow.mutable_mark()->mutable_tail()->set_z(20);
  v1::FileMark circle = mark_at(v1::Mark::CIRCLE, 4, 2);
  circle.mutable_mark()->set_radius(25);
  const FileMarks marks = made({arrow, circle}, 2);
  const PictureRgb8 whole = drawn(marks);
  std::vector<std::uint8_t> rows;
  for (std::uint32_t first = 0; first < 64; first += 20) {
    const PictureRgb8 band = drawn(marks, {64, std::min(20u, 64 - first), first, 64});
    EXPECT_EQ(asked, (Canvas{64, 64}));
    rows.insert(rows.end(), band.pixels.begin(), band.pixels.end());
  }
  EXPECT_EQ(rows, whole.pixels);
}

TEST_F(FileMarksTest, LeavesOutMarksBehindTheEyeAndRefusesDamagedTexts) {
  v1::FileMark behind = mark_at(v1::Mark::TEXT, 0, 0);
  behind.mutable_mark()->mutable_place()->set_y(-200);
  const PictureRgb8 picture = drawn(made({behind}));
  EXPECT_TRUE(std::ranges::all_of(picture.pixels, [](int value) { return value == 0; }));
  v1::FileMark damaged = mark_at(v1::Mark::TEXT, 0, 0);
  damaged.mutable_label()->set_width(40);
  damaged.mutable_label()->set_height(20);
  for (const std::string& coverage : {std::string("no zlib"), std::string()}) {
    damaged.mutable_label()->set_coverage(coverage);
    EXPECT_FALSE(FileMarks::make({damaged}, 1, {}));
  }
  label(damaged, std::string(800, 'a'), std::string(801, 'a'));
  EXPECT_FALSE(FileMarks::make({damaged}, 1, {})) << "longer than its size";
}

}  // namespace
}  // namespace diaphane::render
