#include "ingest/dicom/precheck.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <random>

#include "ingest/dicom/read_slice.h"
#include "tests/support/ingest/test_series.h"

namespace diaphane::dicom {
namespace {

using namespace testing;

Precheck check(const std::string& file, const Limits& limits = {}) {
  return precheck(std::as_bytes(std::span(file)), limits);
}

std::string u16(std::uint32_t v) { return {static_cast<char>(v), static_cast<char>(v >> 8)}; }
std::string u32(std::uint32_t v) { return u16(v) + u16(v >> 16); }

std::string element(std::uint32_t group, std::uint32_t number, const std::string& vr,
                    const std::string& value) {
  return u16(group) + u16(number) + vr + u16(static_cast<std::uint32_t>(value.size())) + value;
}
std::string wide(std::uint32_t group, std::uint32_t number, const std::string& vr,
                 std::uint32_t length, const std::string& value) {
  return u16(group) + u16(number) + vr + u16(0) + u32(length) + value;
}
std::string item(std::uint32_t length) { return u16(0xFFFE) + u16(0xE000) + u32(length); }

std::string header(std::string uid = "1.2.840.10008.1.2.1") {
  if (uid.size() % 2 != 0) uid += '\0';
  return std::string(128, '\0') + "DICM" + element(2, 0x10, "UI", uid);
}

std::string sizes(std::uint32_t rows, std::uint32_t columns, std::uint32_t samples = 1) {
  return element(0x28, 2, "US", u16(samples)) + element(0x28, 0x10, "US", u16(rows)) +
         element(0x28, 0x11, "US", u16(columns)) + element(0x28, 0x100, "US", u16(16));
}

std::string pixels(std::uint32_t length, const std::string& value) {
  return wide(0x7FE0, 0x10, "OW", length, value);
}

TEST(Precheck, AcceptsPlainSlice) {
  const Precheck checked = check(header() + sizes(2, 3) + pixels(12, std::string(12, 'p')));
  EXPECT_EQ(checked.state, FileState::kFit) << checked.text;
  EXPECT_EQ(checked.rows, 2);
  EXPECT_EQ(checked.columns, 3);
  EXPECT_TRUE(checked.has_pixels);
}

TEST(Precheck, ReferencesPixelsWithoutCopyingThem) {
  const std::string file = header() + element(0x28, 8, "IS", "2 ") + sizes(2, 3) +
                           pixels(24, std::string(12, 'p') + std::string(12, 'q'));
  const Precheck checked = check(file);
  ASSERT_EQ(checked.pixels.size(), 1U);
  EXPECT_EQ(checked.pixels[0].size(), 24U);
  const auto* begin = reinterpret_cast<const std::byte*>(file.data());
  EXPECT_GE(checked.pixels[0].data(), begin);
  EXPECT_LE(checked.pixels[0].data() + 24, begin + file.size());
  EXPECT_LT(checked.plain.size(), 300U);
  const auto second = frame_file(checked, 1);
  EXPECT_EQ(std::count(second.begin(), second.end(), std::byte{'q'}), 12);
  EXPECT_EQ(std::count(second.begin(), second.end(), std::byte{'p'}), 0);
  EXPECT_TRUE(frame_file(checked, 2).empty());
}

TEST(Precheck, RefusesTinyFileThatDeclaresAnEnormousImage) {
  const std::string file =
      header() + element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2" + std::string(1, '\0')) +
      sizes(65535, 65535) + pixels(2, "xx");
  ASSERT_LE(file.size(), 286u);
  EXPECT_EQ(check(file).state, FileState::kTooLarge);
}

TEST(Precheck, ImageSizeDoesNotOverflow) {
  // 65535 x 65535 x 65535 x (2^63 - 1) x 8192 exceeds 64 bits and must not wrap around to a small
  // number.
  const std::string file = header() + element(0x28, 2, "US", u16(65535)) +
                           element(0x28, 8, "IS", "9223372036854775807 ") +
                           element(0x28, 0x10, "US", u16(65535)) +
                           element(0x28, 0x11, "US", u16(65535)) +
                           element(0x28, 0x100, "US", u16(65535)) + pixels(2, "xx");
  EXPECT_NE(check(file).state, FileState::kFit);
  const std::string cubes =
      header() + element(0x28, 2, "US", u16(4)) + element(0x28, 8, "IS", "1073741824") +
      element(0x28, 0x10, "US", u16(65536 / 4)) + element(0x28, 0x11, "US", u16(65536 / 2)) +
      element(0x28, 0x100, "US", u16(16)) + pixels(2, "xx");
  EXPECT_EQ(check(cubes).state, FileState::kTooLarge);
}

TEST(Precheck, AcceptsZerosAfterThePixels) {
  const std::string file = header() + sizes(2, 3) + pixels(12, std::string(12, 'p'));
  EXPECT_EQ(check(file + std::string(1001, '\0')).state, FileState::kFit);
  EXPECT_EQ(check(file + std::string(1000, '\0') + "x").state, FileState::kDamaged);
}

TEST(Precheck, RefusesMissingPixels) {
  EXPECT_EQ(check(header() + sizes(8, 8) + pixels(128, std::string(100, 'p'))).state,
            FileState::kDamaged);
  EXPECT_EQ(check(header() + sizes(8, 8) + pixels(100, std::string(100, 'p'))).state,
            FileState::kDamaged);
}

TEST(Precheck, DetectsEveryTruncation) {
  // A truncated file is never fit with pixels, unless only data after the pixels is missing.
  Options options = plain_ct();
  options.series.with_patient = true;
  options.slices = 1;
  options.rows = options.columns = 4;
  const std::string file = files_of(options)[0];
  const std::size_t pixels_end = file.find("Tail") - 12;
  for (std::size_t length = 0; length < file.size(); ++length) {
    const Precheck checked = check(file.substr(0, length));
    EXPECT_FALSE(checked.state == FileState::kFit && checked.has_pixels && length < pixels_end)
        << length;
  }
}

std::string nested(int depth, bool undefined) {
  std::string inner = element(8, 0x104, "LO", "deep");
  for (int i = 0; i < depth; ++i) {
    const std::string end =
        undefined ? u16(0xFFFE) + u16(0xE00D) + u32(0) + u16(0xFFFE) + u16(0xE0DD) + u32(0) : "";
    const std::uint32_t none = 0xFFFFFFFF;
    const std::string one =
        item(undefined ? none : static_cast<std::uint32_t>(inner.size())) + inner;
    inner =
        wide(8, 0x1111, "SQ", undefined ? none : static_cast<std::uint32_t>(one.size()), one + end);
  }
  return inner;
}

TEST(Precheck, LimitsSequenceNestingToSixteen) {
  for (const bool undefined : {false, true}) {
    EXPECT_EQ(check(header() + nested(16, undefined)).state, FileState::kFit);
    EXPECT_EQ(check(header() + nested(17, undefined)).state, FileState::kTooLarge);
  }
}

TEST(Precheck, RefusesNestedSequenceBombWithoutCrash) {
  // 4 MB of sequence starts, which crashed a reader that recurses.
  std::string bomb = header();
  const std::string one = wide(8, 0x1111, "SQ", 0xFFFFFFFF, item(0xFFFFFFFF));
  while (bomb.size() < (4u << 20)) bomb += one;
  EXPECT_EQ(check(bomb).state, FileState::kTooLarge);
  // The same hidden in other representations that readers inspect.
  std::string unknown = header();
  const std::string un = wide(9, 0x1001, "UN", 0xFFFFFFFF, "");
  const std::string implicit = u16(9) + u16(0x1001) + u32(0xFFFFFFFF) + item(0xFFFFFFFF);
  unknown += un + item(0xFFFFFFFF);
  while (unknown.size() < (1u << 20)) unknown += implicit;
  EXPECT_EQ(check(unknown).state, FileState::kTooLarge);
}

TEST(Precheck, RefusesTooManyElements) {
  std::string file = header();
  for (int i = 0; i < 120000; ++i) file += element(0x11, 0x1000 + (i & 0xFF), "LO", "");
  Limits limits;
  limits.elements = 100000;
  EXPECT_EQ(check(file, limits).state, FileState::kTooLarge);
}

TEST(Precheck, RefusesLengthBeyondTheFile) {
  EXPECT_EQ(check(header() + wide(8, 0x1111, "UT", 0x7FFFFFFF, "short")).state,
            FileState::kDamaged);
  EXPECT_EQ(check(header() + wide(8, 0x1111, "SQ", 0xFFFFFFF0, item(8))).state,
            FileState::kDamaged);
  EXPECT_EQ(
      check(header() + wide(8, 0x1111, "SQ", 16, item(0xFFFFFF00) + std::string(8, 'x'))).state,
      FileState::kDamaged);
  EXPECT_EQ(check(header() + wide(8, 0x1111, "OB", 0xFFFFFFFF, "")).state, FileState::kDamaged);
}

std::string deflated(const std::string& data) {
  std::string packed(compressBound(data.size()) + 100, '\0');
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(data.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

TEST(Precheck, StopsDeflateBombAtTheLimit) {
  Limits limits;
  limits.inflated_bytes = 1 << 20;
  const std::string bomb =
      header("1.2.840.10008.1.2.1.99") + deflated(std::string(64u << 20, '\0'));
  ASSERT_LT(bomb.size(), 100000u);
  EXPECT_EQ(check(bomb, limits).state, FileState::kTooLarge);
  const std::string good =
      header("1.2.840.10008.1.2.1.99") + deflated(sizes(2, 3) + pixels(12, std::string(12, 'p')));
  const Precheck checked = check(good, limits);
  EXPECT_EQ(checked.state, FileState::kFit) << checked.text;
  EXPECT_FALSE(checked.plain.empty()) << "GDCM is not to inflate it";
  EXPECT_EQ(check(good.substr(0, good.size() - 3), limits).state, FileState::kDamaged);
}

TEST(Precheck, RefusesCompressedImageOfAnotherSize) {
  // A header of 4 x 4 around a JPEG of 60000 x 60000, whose decoder would believe the JPEG.
  const std::string sof("\xFF\xD8\xFF\xC3\x00\x0B\x10\xEA\x60\xEA\x60\x01\x01\x11\x00", 15);
  const std::string scan("\xFF\xDA\x00\x08\x01\x01\x00\x01\x00\x00 data \xFF\xD9", 18);
  const auto file = [&](const std::string& jpeg) {
    return header("1.2.840.10008.1.2.4.70") + sizes(4, 4) +
           wide(0x7FE0, 0x10, "OB", 0xFFFFFFFF,
                item(0) + item(static_cast<std::uint32_t>(jpeg.size())) + jpeg + u16(0xFFFE) +
                    u16(0xE0DD) + u32(0));
  };
  EXPECT_EQ(check(file(sof + scan)).state, FileState::kDamaged);
  std::string right = sof + scan;
  right.replace(7, 4, std::string("\x00\x04\x00\x04", 4));
  EXPECT_EQ(check(file(right)).state, FileState::kFit) << check(file(right)).text;
  EXPECT_EQ(check(file("no JPEG.")).state, FileState::kDamaged);
  EXPECT_EQ(check(file(right.substr(0, 15))).state, FileState::kDamaged) << "no scan";
  EXPECT_EQ(check(file(right.substr(0, 15) + scan.substr(0, 16) + scan)).state, FileState::kDamaged)
      << "a scan more than components";
  EXPECT_EQ(check(file(right.substr(0, 15) + sof.substr(2) + scan)).state, FileState::kDamaged)
      << "a second size";
  for (const int marker : {0xC0, 0xC1, 0xC2, 0xCB}) {
    std::string other = right;
    other[3] = static_cast<char>(marker);
    EXPECT_EQ(check(file(other)).state, FileState::kDamaged) << "another process than 1.2...4.70";
  }
  for (const int bits : {0, 2, 7, 17, 200}) {
    std::string other = right;
    other[6] = static_cast<char>(bits);
    EXPECT_EQ(check(file(other)).state, FileState::kDamaged) << bits;
  }
}

TEST(Precheck, RefusesRunLengthsThatDoNotMatchTheImageSize) {
  const auto file = [&](const std::string& frame, std::uint32_t segments) {
    std::string head = u32(segments) + u32(64) + u32(64 + static_cast<std::uint32_t>(frame.size()));
    head.resize(64);
    const std::string all = head + frame + frame;
    return header("1.2.840.10008.1.2.5") + sizes(16, 16) +
           wide(0x7FE0, 0x10, "OB", 0xFFFFFFFF,
                item(0) + item(static_cast<std::uint32_t>(all.size())) + all + u16(0xFFFE) +
                    u16(0xE0DD) + u32(0));
  };
  const std::string run("\x81\x00", 2);  // 128 zeros
  EXPECT_EQ(check(file(run + run, 2)).state, FileState::kFit) << check(file(run + run, 2)).text;
  EXPECT_EQ(check(file(run + run + "\x80\x80", 2)).state, FileState::kFit) << "filled up";
  EXPECT_EQ(check(file(run, 2)).state, FileState::kDamaged);
  EXPECT_EQ(check(file(run + run + run + run, 2)).state, FileState::kDamaged);
  EXPECT_EQ(check(file(run + run, 1)).state, FileState::kDamaged);
  EXPECT_EQ(check(file(run + run, 0xF0000002)).state, FileState::kDamaged);
}

TEST(Precheck, CountsBytesOfInflatedFiles) {
  const std::string packed =
      header("1.2.840.10008.1.2.1.99") + deflated(sizes(2, 3) + pixels(12, std::string(12, 'p')));
  EXPECT_EQ(check(packed).unpacked_bytes, (sizes(2, 3) + pixels(12, std::string(12, 'p'))).size());
  EXPECT_EQ(check(header() + sizes(2, 3) + pixels(12, std::string(12, 'p'))).unpacked_bytes, 0u);
  Limits limits;
  limits.inflated_free = 1 << 20;
  const std::string bomb = header("1.2.840.10008.1.2.1.99") + deflated(std::string(4 << 20, '\0'));
  EXPECT_EQ(check(bomb, limits).state, FileState::kTooLarge);
  EXPECT_GT(check(bomb, limits).unpacked_bytes, 0u) << "what it cost counts although it is refused";
}

TEST(Precheck, RefusesPixelsWithAnotherValueRepresentation) {
  for (const char* vr : {"SQ", "UN", "UT"}) {
    EXPECT_EQ(check(header() + sizes(2, 3) + wide(0x7FE0, 0x10, vr, 12, item(4) + "1234")).state,
              FileState::kDamaged)
        << vr;
  }
}

TEST(Precheck, RefusesAmbiguousElements) {
  const std::string body = sizes(2, 3) + pixels(12, std::string(12, 'p'));
  EXPECT_EQ(check(header() + element(0x28, 0x10, "US", u16(2)) + body).state, FileState::kDamaged);
  EXPECT_EQ(check(header() + body + pixels(12, std::string(12, 'q'))).state, FileState::kDamaged);
  EXPECT_EQ(
      check(header() + element(0x28, 0x10, "UL", u32(2)) + pixels(12, std::string(12, 'p'))).state,
      FileState::kDamaged);
}

TEST(Precheck, RefusesPixelsWithoutTheirDescription) {
  const std::string own = element(0x09, 0x10, "LO", "OF ITS OWN ");
  EXPECT_EQ(check(header() + own + pixels(2, "pq")).state, FileState::kDamaged);
  EXPECT_EQ(check(header() + own).state, FileState::kFit) << "no slice, and GDCM is not asked";
  // A single frame's file omits the number of frames, which would leave nothing of this header.
  EXPECT_EQ(check(header() + element(0x28, 8, "IS", "2 ") + pixels(2, "pq")).state,
            FileState::kDamaged);
  EXPECT_EQ(check(header() + sizes(0, 3) + pixels(2, "pq")).state, FileState::kDamaged);
  // Zero samples do not turn the largest image into one of zero bytes.
  EXPECT_EQ(check(header() + sizes(65535, 65535, 0) + pixels(2, "pq")).state, FileState::kTooLarge);
  EXPECT_EQ(check(header() + sizes(1, 1, 0) + pixels(2, "pq")).state, FileState::kDamaged);
}

TEST(Precheck, RecognizesFilesThatAreNotDicom) {
  for (const std::string file :
       {std::string(), std::string("x"), std::string(131, '\0'), std::string(5000, '\0'),
        std::string("\x89PNG\r\n\x1a\n and so on and on and on"),
        std::string("PK\x03\x04 an archive ................")}) {
    EXPECT_EQ(check(file).state, FileState::kNotDicom) << file.size();
  }
  EXPECT_EQ(check(std::string(128, '\0') + "DICM").state, FileState::kDamaged);
}

/// Flips, truncates, repeats and overwrites bytes, from one seed: a small fuzzer that every test
/// run repeats.
std::string mutated(std::string file, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return random() % n; };
  const int changes = 1 + static_cast<int>(below(6));
  for (int i = 0; i < changes && file.size() > 200; ++i) {
    const std::size_t at = 128 + below(file.size() - 128);
    switch (below(5)) {
      case 0:
        file[at] = static_cast<char>(random());
        break;
      case 1:
        file.resize(at);
        break;
      case 2:
        file.insert(at, file.substr(at, below(40)));
        break;
      case 3:
        file.replace(at, std::min<std::size_t>(4, file.size() - at), "\xFF\xFF\xFF\xFF", 4);
        break;
      default:
        file.erase(at, below(20));
        break;
    }
  }
  return file;
}

TEST(Precheck, GdcmSurvivesMutatedFilesThatPass) {
  // 20 000 changed files. GDCM must survive every file that passes the pre-check, within this
  // process.
  std::mt19937 random(20261121);
  std::vector<std::string> seeds;
  for (const char* uid :
       {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2", "1.2.840.10008.1.2.1.99",
        "1.2.840.10008.1.2.4.70", "1.2.840.10008.1.2.5"}) {
    Options options = plain_ct();
    options.slices = 1;
    options.rows = options.columns = 16;
    options.series.transfer_syntax = uid;
    options.series.with_patient = true;
    seeds.push_back(files_of(options)[0]);
  }
  Limits limits;
  limits.pixel_bytes = 1 << 20;
  limits.inflated_bytes = 1 << 20;
  std::size_t passed = 0;
  for (int round = 0; round < 20000; ++round) {
    const std::string file = mutated(seeds[random() % seeds.size()], random);
    const Precheck checked = check(file, limits);
    if (checked.state != FileState::kFit) {
      EXPECT_FALSE(checked.text.empty());
      continue;
    }
    ++passed;
    EXPECT_LE(std::uint64_t{checked.rows} * checked.columns * 2, limits.pixel_bytes * 2);
    const auto slices = read_slices(checked);
    for (const Slice& slice : slices.value_or(std::vector<Slice>())) {
      (void)read_values(checked, slice);
    }
  }
  EXPECT_GT(passed, 500u) << "else nothing was tried";
}

}  // namespace
}  // namespace diaphane::dicom
