#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "ingest/labels/read_labels.h"

namespace diaphane::ingest {
namespace {

using Place = std::array<double, 3>;

// Writes data sets in explicit VR little endian.

std::string u16(unsigned value) {
  return {static_cast<char>(value & 0xff), static_cast<char>(value >> 8 & 0xff)};
}
std::string u32(std::size_t value) {
  return u16(static_cast<unsigned>(value & 0xffff)) + u16(static_cast<unsigned>(value >> 16));
}
std::string element(std::uint32_t tag, const std::string& vr, std::string value) {
  if (value.size() % 2 != 0) value += vr == "UI" || vr == "OB" ? '\0' : ' ';
  const std::string head = u16(tag >> 16) + u16(tag & 0xffff) + vr;
  const bool wide = vr == "SQ" || vr == "OB" || vr == "OW";
  return head + (wide ? u16(0) + u32(value.size()) : u16(static_cast<unsigned>(value.size()))) +
         value;
}
std::string sequence(std::uint32_t tag, const std::vector<std::string>& items) {
  std::string value;
  for (const std::string& item : items)
    value += u16(0xFFFE) + u16(0xE000) + u32(item.size()) + item;
  return element(tag, "SQ", value);
}
std::string decimals(const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) {
    char one[32];
    std::snprintf(one, sizeof one, "%s%.6g", text.empty() ? "" : "\\", number);
    text += one;
  }
  return text;
}
std::string file_of(const std::string& data_set) {
  const std::string meta = element(0x00020010, "UI", "1.2.840.10008.1.2.1");
  return std::string(128, '\0') + "DICM" + meta + data_set;
}

constexpr const char* kSegClass = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr const char* kStructureClass = "1.2.840.10008.5.1.4.1.1.481.3";

/// An axial scan of 16 x 12 x 10 voxels of 2 x 1.5 x 3 mm.
volume::Header scan() {
  volume::Header header;
  header.size = {16, 12, 10};
  header.spacing = {2, 1.5, 3};
  header.origin = Place{-20, 30, -100};
  header.frame_of_reference = "1.2.3";
  return header;
}

Place at(const volume::Header& h, double x, double y, double z) {
  Place place = *h.origin;
  const double steps[] = {x, y, z};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t i = 0; i < 3; ++i)
      place[row] += h.direction[3 * row + i] * h.spacing[i] * steps[i];
  }
  return place;
}

/// A segmentation of two segments on the grid of scan(), one frame per slice and segment.
struct Segmentation {
  std::string type = "BINARY";
  std::string frame_of_reference = "1.2.3";
  std::vector<int> segments{1, 5};
  std::vector<int> slices{2, 3, 4};
  /// The fraction of a segment at a voxel, 0 to 1.
  std::function<double(int segment, int x, int y, int z)> inside = [](int segment, int x, int y,
                                                                      int z) {
    const bool block = x >= 3 && x < 8 && y >= 4 && y < 7 && z > 1;
    return block && (segment == 1 || x > 5) ? 1.0 : 0.0;
  };
  Place shift{};        ///< mm, of all frames
  double uneven = 0;    ///< mm, of the last slice
  std::size_t cut = 0;  ///< bytes that are missing at the end

  std::string file() const {
    const volume::Header h = scan();
    std::vector<std::string> table, frames;
    std::string pixels;
    std::size_t bits = 0;
    for (const int segment : segments) {
      table.push_back(element(0x00620004, "US", u16(static_cast<unsigned>(segment))) +
                      element(0x00620005, "LO", segment == 1 ? "Liver" : "Vein") +
                      element(0x0062000D, "US", u16(34894) + u16(53519) + u16(50162)));
      for (const int z : slices) {
        Place p = at(h, 0, 0, z);
        for (std::size_t i = 0; i < 3; ++i) p[i] += shift[i];
        if (z == slices.back()) p[2] += uneven;
        frames.push_back(
            sequence(0x00209113, {element(0x00200032, "DS", decimals({p[0], p[1], p[2]}))}) +
            sequence(0x0062000A, {element(0x0062000B, "US", u16(static_cast<unsigned>(segment)))}));
        for (int y = 0; y < 12; ++y) {
          for (int x = 0; x < 16; ++x, ++bits) {
            const double value = inside(segment, x, y, z);
            if (type != "BINARY") {
              pixels += static_cast<char>(std::lround(200 * value));
            } else {
              if (bits % 8 == 0) pixels += '\0';
              if (value > 0) pixels.back() = static_cast<char>(pixels.back() | 1 << bits % 8);
            }
          }
        }
      }
    }
    const std::string shared =
        sequence(0x00209116, {element(0x00200037, "DS", "1\\0\\0\\0\\1\\0")}) +
        sequence(0x00289110, {element(0x00280030, "DS", "1.5\\2")});
    const bool binary = type == "BINARY";
    std::string file =
        file_of(element(0x00080016, "UI", kSegClass) +
                element(0x00200052, "UI", frame_of_reference) + element(0x00280002, "US", u16(1)) +
                element(0x00280008, "IS", std::to_string(frames.size())) +
                element(0x00280010, "US", u16(12)) + element(0x00280011, "US", u16(16)) +
                element(0x00280100, "US", u16(binary ? 1 : 8)) + element(0x00620001, "CS", type) +
                sequence(0x00620002, table) + element(0x0062000E, "US", u16(200)) +
                sequence(0x52009229, {shared}) + sequence(0x52009230, frames) +
                element(0x7FE00010, "OB", pixels));
    file.resize(file.size() - cut);
    return file;
  }
};

Result<volume::LabelSet> read(const std::string& file, const volume::Header& h = scan()) {
  return read_labels(std::as_bytes(std::span(file)), h);
}
std::string refusal(const std::string& file, const volume::Header& h = scan()) {
  const auto set = read(file, h);
  return set ? "accepted" : set.error().message;
}

std::uint8_t label_at(const volume::LabelSet& set, std::size_t x, std::size_t y, std::size_t z) {
  return set.labels.voxels[x + set.labels.size[0] * (y + set.labels.size[1] * z)];
}

TEST(Segmentation, BinaryFramesMarkTheirVoxels) {
  const Segmentation made;
  const auto set = read(made.file());
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(set->table.size(), 2U);
  EXPECT_EQ(set->table[0].name, "Liver");
  EXPECT_EQ(set->table[1].number, 5U);
  // L 53, a 80, b 67 is the red of sRGB.
  EXPECT_GT(set->table[0].colour[0], 245);
  EXPECT_LT(set->table[0].colour[1], 20);
  for (std::size_t z = 0; z < 10; ++z) {
    for (std::size_t y = 0; y < 12; ++y) {
      for (std::size_t x = 0; x < 16; ++x) {
        const bool block = x >= 3 && x < 8 && y >= 4 && y < 7 && z >= 2 && z < 5;
        ASSERT_EQ(label_at(*set, x, y, z), !block ? 0 : x > 5 ? 2 : 1) << x << ' ' << y << ' ' << z;
      }
    }
  }
}

TEST(Segmentation, ScansOfAnyOrientationAreMarkedAlike) {
  volume::Header turned = scan();  // the same box, sagittal and from the other end
  turned.size = {12, 10, 16};
  turned.spacing = {1.5, 3, 2};
  turned.direction = {0, 0, -1, -1, 0, 0, 0, 1, 0};
  turned.origin = at(scan(), 15, 11, 0);
  const auto set = read(Segmentation().file(), turned);
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_EQ(label_at(*set, 11 - 4, 2, 15 - 3), 1);
  EXPECT_EQ(label_at(*set, 11 - 4, 2, 15 - 7), 2);
  EXPECT_EQ(label_at(*set, 11 - 4, 2, 15 - 8), 0);
  EXPECT_EQ(label_at(*set, 11 - 4, 5, 15 - 3), 0);
}

TEST(Segmentation, TheLargerFractionWins) {
  Segmentation made;
  made.type = "FRACTIONAL";
  made.inside = [](int segment, int x, int, int) {
    return segment == 1 ? x / 15.0 : 0.8;  // the first overtakes the second from x = 12 on
  };
  const auto set = read(made.file());
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_EQ(label_at(*set, 0, 5, 3), 2);
  EXPECT_EQ(label_at(*set, 10, 5, 3), 2);
  EXPECT_EQ(label_at(*set, 13, 5, 3), 1);
  made.segments = {1};
  EXPECT_EQ(label_at(*read(made.file()), 7, 5, 3), 0) << "less than half";
  EXPECT_EQ(label_at(*read(made.file()), 8, 5, 3), 1);
}

TEST(Segmentation, MissingSlicesStayEmpty) {
  Segmentation made;
  made.slices = {2, 3, 6};
  const auto set = read(made.file());
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_EQ(label_at(*set, 4, 5, 3), 1);
  EXPECT_EQ(label_at(*set, 4, 5, 4), 0);
  EXPECT_EQ(label_at(*set, 4, 5, 5), 0);
  EXPECT_EQ(label_at(*set, 4, 5, 6), 1);
}

TEST(Segmentation, RefusesOtherScansInWords) {
  Segmentation made;
  made.frame_of_reference = "1.2.4";
  EXPECT_EQ(refusal(made.file()),
            "These labels do not belong to this scan: they use another frame of reference.");
  made = {};
  made.shift = {400, 0, 0};
  EXPECT_EQ(refusal(made.file()),
            "These labels do not belong to this scan: none of them overlaps it.");
  volume::Header converted = scan();
  converted.frame_of_reference.clear();
  EXPECT_EQ(refusal(Segmentation().file(), converted), "accepted") << "by its place alone";
}

TEST(Segmentation, RefusesUnevenAndDamagedFiles) {
  Segmentation made;
  made.uneven = 1;
  EXPECT_NE(refusal(made.file()).find("not evenly spaced"), std::string::npos);
  made = {};
  const std::string whole = made.file();
  for (std::size_t cut = 1; cut + 200 < whole.size(); cut += 7) {
    EXPECT_NE(refusal(whole.substr(0, whole.size() - cut)), "accepted") << cut;
  }
  made.type = "LABELMAP";
  EXPECT_NE(refusal(made.file()).find("Only binary and fractional"), std::string::npos);
  EXPECT_NE(refusal("hello, this is not a label file").find("not a file of labels"),
            std::string::npos);
}

/// A structure set with one contour list per structure, in voxel indices of scan().
struct StructureSet {
  struct Contour {
    std::vector<Place> points;
    std::string shape = "CLOSED_PLANAR";
  };
  std::vector<std::vector<Contour>> structures;
  std::string frame_of_reference = "1.2.3";

  std::string file(const volume::Header& h = scan()) const {
    std::vector<std::string> named, drawn;
    for (std::size_t i = 0; i < structures.size(); ++i) {
      named.push_back(element(0x30060022, "IS", std::to_string(i)) +
                      element(0x30060024, "UI", frame_of_reference) +
                      element(0x30060026, "LO", "Organ " + std::to_string(i)));
      std::vector<std::string> contours;
      for (const Contour& contour : structures[i]) {
        std::vector<double> numbers;
        for (const Place& p : contour.points) {
          for (const double v : at(h, p[0], p[1], p[2])) numbers.push_back(v);
        }
        contours.push_back(element(0x30060042, "CS", contour.shape) +
                           element(0x30060050, "DS", decimals(numbers)));
      }
      drawn.push_back(element(0x3006002A, "IS", "10\\200\\30") + sequence(0x30060040, contours) +
                      element(0x30060084, "IS", std::to_string(i)));
    }
    return file_of(element(0x00080016, "UI", kStructureClass) + sequence(0x30060020, named) +
                   sequence(0x30060039, drawn));
  }
};

StructureSet::Contour square(double x0, double y0, double x1, double y1, double z) {
  return {{{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}}};
}

TEST(StructureSet, FillsContoursByTheEvenOddRule) {
  StructureSet made;
  // A square with a hole on two slices, and an island in the hole on one of them.
  made.structures = {{square(1.5, 1.5, 12.5, 10.5, 4), square(4.5, 3.5, 9.5, 8.5, 4),
                      square(6.5, 5.5, 7.5, 6.5, 4), square(1.5, 1.5, 12.5, 10.5, 5),
                      square(4.5, 3.5, 9.5, 8.5, 5)}};
  const auto set = read(made.file());
  ASSERT_TRUE(set) << set.error().message;
  ASSERT_EQ(set->table.size(), 1U);
  EXPECT_EQ(set->table[0].name, "Organ 0");
  EXPECT_EQ(set->table[0].colour, (std::array<std::uint8_t, 3>{10, 200, 30}));
  for (std::size_t z = 0; z < 10; ++z) {
    for (std::size_t y = 0; y < 12; ++y) {
      for (std::size_t x = 0; x < 16; ++x) {
        const bool outer = x >= 2 && x <= 12 && y >= 2 && y <= 10;
        const bool hole = x >= 5 && x <= 9 && y >= 4 && y <= 8;
        const bool island = x == 7 && y == 6 && z == 4;
        const bool marked = (z == 4 || z == 5) && ((outer && !hole) || island);
        ASSERT_EQ(label_at(*set, x, y, z), marked ? 1 : 0) << x << ' ' << y << ' ' << z;
      }
    }
  }
}

TEST(StructureSet, ContoursOnEverySecondSliceFillTheSlicesBetween) {
  StructureSet made;
  made.structures = {{square(1.5, 1.5, 5.5, 5.5, 2), square(1.5, 1.5, 5.5, 5.5, 4),
                      square(1.5, 1.5, 5.5, 5.5, 6)}};
  const auto set = read(made.file());
  ASSERT_TRUE(set) << set.error().message;
  const std::array<int, 10> expected{0, 1, 1, 1, 1, 1, 1, 1, 0, 0};
  for (std::size_t z = 0; z < 10; ++z) EXPECT_EQ(label_at(*set, 3, 3, z), expected[z]) << z;
}

TEST(StructureSet, IgnoresPointsAndRefusesOtherScans) {
  StructureSet made;
  auto point = square(1, 1, 2, 2, 3);
  point.shape = "POINT";
  made.structures = {{point}};
  EXPECT_EQ(refusal(made.file()), "The structure set contains no closed contours.");
  made.structures = {{square(1, 1, 5, 5, 3)}};
  made.frame_of_reference = "9.9";
  EXPECT_NE(refusal(made.file()).find("another frame of reference"), std::string::npos);
  made.frame_of_reference = "1.2.3";
  EXPECT_EQ(refusal(made.file()), "accepted");
  made.structures = {{square(101, 1, 105, 5, 3)}};
  EXPECT_NE(refusal(made.file()).find("none of them overlaps"), std::string::npos);
  volume::Header unplaced = scan();
  unplaced.origin.reset();
  EXPECT_NE(refusal(made.file(), unplaced).find("where it lies"), std::string::npos);
}

TEST(StructureSet, ContoursAlongAnotherAxisAreFilledToo) {
  volume::Header sagittal = scan();
  sagittal.size = {12, 10, 16};
  sagittal.spacing = {1.5, 3, 2};
  sagittal.direction = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  StructureSet made;
  made.structures = {{square(1.5, 1.5, 5.5, 7.5, 4)}};
  const auto set = read(made.file(), sagittal);  // drawn on axial slices
  ASSERT_TRUE(set) << set.error().message;
  EXPECT_EQ(label_at(*set, 2, 4, 2), 1);
  EXPECT_EQ(label_at(*set, 7, 4, 5), 1);
  EXPECT_EQ(label_at(*set, 8, 4, 5), 0);
  EXPECT_EQ(label_at(*set, 7, 4, 6), 0);
  EXPECT_EQ(label_at(*set, 2, 5, 2), 0);
  StructureSet oblique;
  oblique.structures = {{{{{1, 1, 1}, {9, 2, 3}, {3, 8, 6}, {2, 4, 2}}}}};
  EXPECT_NE(refusal(oblique.file()).find("not parallel"), std::string::npos);
}

TEST(StructureSet, DamagedFilesAreRefused) {
  StructureSet made;
  made.structures = {{square(1, 1, 5, 5, 3)}};
  const std::string whole = made.file();
  for (std::size_t cut = 1; cut + 200 < whole.size(); cut += 3) {
    EXPECT_NE(refusal(whole.substr(0, whole.size() - cut)), "accepted") << cut;
  }
  LabelLimits limits;
  limits.points = 3;
  EXPECT_EQ(read_labels(std::as_bytes(std::span(whole)), scan(), limits).error().code,
            ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace diaphane::ingest
