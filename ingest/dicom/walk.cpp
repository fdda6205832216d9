#include "ingest/dicom/walk.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

namespace diaphane::dicom {
namespace {

constexpr std::uint32_t kUndefined = 0xFFFFFFFF;
constexpr std::uint32_t kItem = 0xFFFEE000;
constexpr std::uint32_t kItemEnd = 0xFFFEE00D;
constexpr std::uint32_t kSequenceEnd = 0xFFFEE0DD;
constexpr std::uint32_t kModalityLookupTable = 0x00283000;
constexpr std::uint32_t kExtendedOffsets = 0x7FE00001;

/// Tags of all elements that are read (dicom/slice.h), sorted for a binary search.
constexpr std::array<std::uint32_t, 46> kNeeded{
    0x00080008, 0x00080016, 0x00080018, 0x00080032, 0x00080033, 0x00080060, 0x00100010, 0x00100020,
    0x00180081, 0x00181060, 0x00189082, 0x00189087, 0x00190010, 0x0019100C, 0x0020000E, 0x00200013,
    0x00200032, 0x00200037, 0x00200052, 0x00200100, 0x00209128, 0x00209153, 0x00209241, 0x0020930D,
    0x00280002, 0x00280004, 0x00280006, 0x00280008, 0x00280010, 0x00280011, 0x00280030, 0x00280100,
    0x00280101, 0x00280102, 0x00280103, 0x00280120, 0x00280121, 0x00281050, 0x00281051, 0x00281052,
    0x00281053, 0x00282110, 0x00430010, 0x00431039, 0x20010010, 0x20011003};
constexpr std::uint32_t kLongestNeeded = 1024;

/// Elements of functional groups that are read, each with the only group in which it is read.
constexpr std::uint32_t kSharedGroups = 0x52009229;
constexpr std::uint32_t kFrameGroups = 0x52009230;
struct Grouped {
  std::uint32_t group, tag;
};
constexpr std::array<Grouped, 17> kGrouped{{
    {0x00209113, 0x00200032},  // plane position
    {0x00209116, 0x00200037},  // plane orientation
    {0x00289110, 0x00280030},  // pixel measures
    {0x00289145, 0x00281052},  // pixel value transformation
    {0x00289145, 0x00281053},
    {0x00289132, 0x00281050},  // frame VOI LUT
    {0x00289132, 0x00281051},
    {0x00209111, 0x00209056},  // frame content: stack
    {0x00189329, 0x00089007},  // frame type, of CT
    {0x00189226, 0x00089007},  // frame type, of MR
    {0x00189751, 0x00089007},  // frame type, of PET
    {0x00209111, 0x00209128},  // frame content: temporal position
    {0x00209310, 0x0020930D},  // temporal position: time offset
    {0x00189118, 0x00209153},  // cardiac synchronisation: trigger delay
    {0x00189118, 0x00209241},  // cardiac synchronisation: percentage of the phase
    {0x00189114, 0x00189082},  // MR echo: effective echo time
    {0x00189117, 0x00189087},  // MR diffusion: b-value
}};

/// Returns the bytes of an element that distinguishes phases by one binary number (FD, FL or UL),
/// or 0. Such an element is left out if it has another length.
std::uint32_t binary_width(std::uint32_t tag) {
  switch (tag) {
    case 0x00189082:
    case 0x00189087:
    case 0x00209153:
    case 0x0020930D:
      return 8;
    case 0x00209128:
    case 0x00209241:
      return 4;
    default:
      return 0;
  }
}

/// Thrown only within this file to leave the recursion. walk() converts it to a result.
struct Stop {
  FileState state;
  const char* text;
};

[[noreturn]] void damaged(const char* text) { throw Stop{FileState::kDamaged, text}; }

class Walker {
 public:
  Walker(std::span<const std::byte> data, bool explicit_vr, bool big_endian, const Limits& limits,
         DataSet* tree)
      : data_(data),
        explicit_(explicit_vr),
        big_endian_(big_endian),
        limits_(limits),
        into_(tree) {}

  void run() {
    data_set(data_.size(), false, explicit_, 0);
    std::vector<Range>& kept = result_.kept;
    std::sort(kept.begin(), kept.end(),
              [](const Range& a, const Range& b) { return a.tag < b.tag; });
    const auto same = [](const Range& a, const Range& b) { return a.tag == b.tag; };
    if (std::adjacent_find(kept.begin(), kept.end(), same) != kept.end()) {
      damaged("an element occurs twice");
    }
  }
  Walked& result() { return result_; }

 private:
  struct Element {
    std::uint32_t tag = 0;
    std::array<char, 2> vr{};  ///< zeros if the syntax has none
    std::uint32_t length = 0;
    bool is(const char* name) const { return vr[0] == name[0] && vr[1] == name[1]; }
  };

  std::uint8_t byte(std::size_t at) const { return std::to_integer<std::uint8_t>(data_[at]); }
  std::uint16_t read16(std::size_t at) const {
    const unsigned a = byte(at), b = byte(at + 1);
    return static_cast<std::uint16_t>(big_endian_ ? a << 8 | b : b << 8 | a);
  }
  std::uint32_t read32(std::size_t at) const {
    const std::uint32_t a = read16(at), b = read16(at + 2);
    return big_endian_ ? a << 16 | b : b << 16 | a;
  }
  std::uint32_t tag_at(std::size_t at) const {
    return std::uint32_t{read16(at)} << 16 | read16(at + 2);
  }
  void need(std::uint64_t bytes, std::size_t end) const {
    if (bytes > end - at_) damaged("the file is incomplete");
  }

  Element next(std::size_t end, bool explicit_vr) {
    if (++elements_ > limits_.elements)
      throw Stop{FileState::kTooLarge, "the file has too many elements"};
    need(8, end);
    Element e;
    e.tag = tag_at(at_);
    if (!explicit_vr || e.tag >> 16 == 0xFFFE) {
      e.length = read32(at_ + 4);
      at_ += 8;
      return e;
    }
    e.vr = {static_cast<char>(byte(at_ + 4)), static_cast<char>(byte(at_ + 5))};
    static constexpr std::string_view kKnown =
        "AE AS AT CS DA DS DT FD FL IS LO LT OB OD OF OL OV OW PN SH SL SQ SS ST SV TM UC UI UL UN "
        "UR US UT UV ";
    static constexpr std::string_view kLong = "OB OD OF OL OV OW SQ SV UC UN UR UT UV ";
    const char name[] = {e.vr[0], e.vr[1], ' ', '\0'};
    if (kKnown.find(name) == std::string_view::npos)
      damaged("an element has an unknown value representation");
    if (kLong.find(name) == std::string_view::npos) {
      e.length = read16(at_ + 6);
      at_ += 8;
    } else {
      need(12, end);
      e.length = read32(at_ + 8);
      at_ += 12;
    }
    return e;
  }

  /// Returns whether only zeros follow, with which some writers pad their files to whole blocks.
  bool only_zeros(std::size_t end) const {
    return std::all_of(data_.begin() + static_cast<std::ptrdiff_t>(at_),
                       data_.begin() + static_cast<std::ptrdiff_t>(end),
                       [](std::byte b) { return b == std::byte{0}; });
  }

  /// Reads elements until `end`, or until the item's end mark if `open`.
  void data_set(std::size_t end, bool open, bool explicit_vr, std::uint32_t depth) {
    while (at_ < end) {
      if (depth == 0 && result_.has_pixels && only_zeros(end)) return;
      const std::size_t begin = at_;
      const Element e = next(end, explicit_vr);
      if (e.tag == kItemEnd && open) {
        if (e.length != 0) damaged("an item delimiter has a length");
        return;
      }
      if (e.tag >> 16 == 0xFFFE) damaged("an item appears in place of an element");
      if (into_ != nullptr) into_->push_back({e.tag, {}, {}});
      if (depth == 0 && e.tag == kPixelData) {
        pixels(e, end);
      } else {
        if (depth == 0) top_ = e.tag;
        if (depth == 1) group_ = e.tag;
        const bool is_plain = element(e, end, explicit_vr, depth);
        if (depth == 0) note(e, begin, is_plain);
        if (depth == 2 && is_plain) note_grouped(e);
      }
    }
    if (open) damaged("the file is incomplete");
  }

  /// Skips an element and returns true, or returns false for one that contains others.
  bool element(const Element& e, std::size_t end, bool explicit_vr, std::uint32_t depth) {
    if (e.length == kUndefined) {
      if (explicit_vr && !e.is("SQ") && !e.is("UN")) damaged("an element has no length");
      // An element of unknown representation and undefined length is implicit inside (DICOM PS3.5,
      // 6.2.2, note 2).
      sequence(end, true, explicit_vr && e.is("SQ"), depth + 1);
      return false;
    }
    need(e.length, end);
    const std::size_t stop = at_ + e.length;
    // Readers look for items even if the representation is not "sequence".
    const bool hidden = (!explicit_vr || e.is("UN")) && e.length >= 8 && tag_at(at_) == kItem;
    const bool holds_others = e.is("SQ") || hidden;
    if (!holds_others && into_ != nullptr) into_->back().value = data_.subspan(at_, e.length);
    if (holds_others) sequence(stop, false, explicit_vr && e.is("SQ"), depth + 1);
    at_ = stop;
    return !holds_others;
  }

  void sequence(std::size_t end, bool open, bool explicit_vr, std::uint32_t depth) {
    if (depth > limits_.nesting)
      throw Stop{FileState::kTooLarge, "sequences are nested too deeply"};
    while (at_ < end) {
      const Element item = next(end, false);
      if (item.tag == kSequenceEnd && open) {
        if (item.length != 0) damaged("a sequence delimiter has a length");
        return;
      }
      if (item.tag != kItem) damaged("a sequence contains something other than items");
      if (depth == 1 && top_ == kFrameGroups) result_.each.emplace_back();
      if (depth == 1 && (top_ == kFrameGroups || top_ == kSharedGroups)) result_.has_groups = true;
      DataSet* const outer = into_;
      if (outer != nullptr) into_ = &outer->back().items.emplace_back();
      if (item.length == kUndefined) {
        data_set(end, true, explicit_vr, depth);
      } else {
        need(item.length, end);
        data_set(at_ + item.length, false, explicit_vr, depth);
      }
      into_ = outer;
    }
    if (open) damaged("the file is incomplete");
  }

  void pixels(const Element& e, std::size_t end) {
    if (result_.has_pixels) damaged("there are two sets of pixel data");
    result_.has_pixels = true;
    // GDCM aborts with a failed assertion on a sequence.
    if (explicit_ && !e.is("OW") && !e.is("OB")) damaged("the pixel data element is invalid");
    if (e.length != kUndefined) {
      need(e.length, end);
      result_.native = {e.tag, at_, at_ + e.length};
      if (into_ != nullptr) into_->back().value = data_.subspan(at_, e.length);
      at_ += e.length;
      return;
    }
    result_.encapsulated = true;
    while (true) {
      const Element fragment = next(end, false);
      if (fragment.tag == kSequenceEnd) {
        if (fragment.length != 0)
          damaged("the delimiter of the compressed pixel data has a length");
        return;
      }
      if (fragment.tag != kItem || fragment.length == kUndefined)
        damaged("the compressed pixel data is corrupted");
      need(fragment.length, end);
      result_.fragments.push_back({fragment.tag, at_, at_ + fragment.length});
      at_ += fragment.length;
    }
  }

  void note(const Element& e, std::size_t begin, bool is_plain) {
    if (e.tag == kModalityLookupTable) result_.has_lookup_table = true;
    if (e.tag == kExtendedOffsets && is_plain) result_.long_offsets = {e.tag, at_ - e.length, at_};
    if (!std::binary_search(kNeeded.begin(), kNeeded.end(), e.tag)) return;
    if (!is_plain || e.length > kLongestNeeded) damaged("an element has an unexpected form");
    if (const std::uint32_t width = binary_width(e.tag); width > 0 && e.length != width) return;
    result_.kept.push_back({e.tag, begin, at_});
    switch (e.tag) {
      case 0x00280002:
        return number(e, result_.samples);
      case 0x00280010:
        return number(e, result_.rows);
      case 0x00280011:
        return number(e, result_.columns);
      case 0x00280100:
        return number(e, result_.bits_allocated);
      case 0x00280008:
        return frames(e);
      default:
        return;
    }
  }

  /// Records the value of a functional group that was just passed.
  void note_grouped(const Element& e) {
    if (top_ != kFrameGroups && top_ != kSharedGroups) return;
    const bool needed = std::any_of(kGrouped.begin(), kGrouped.end(), [&](const Grouped& g) {
      return g.group == group_ && g.tag == e.tag;
    });
    if (!needed) return;
    if (e.length > kLongestNeeded) damaged("an element has an unexpected form");
    auto& into = top_ == kFrameGroups ? result_.each.back() : result_.shared;
    into.push_back({e.tag, at_ - e.length, at_});
  }

  /// Reads the 16-bit value of the element that was just passed.
  void number(const Element& e, std::optional<std::uint16_t>& into) const {
    // Two readers could derive two different sizes from an unusual form.
    if (e.length != 2 || (explicit_ && !e.is("US"))) damaged("the size of the image is unclear");
    into = read16(at_ - 2);
  }

  void frames(const Element& e) {
    std::string text;
    for (std::uint32_t i = 0; i < std::min<std::uint32_t>(e.length, 16); ++i) {
      const char c = static_cast<char>(byte(at_ - e.length + i));
      if (c != ' ' && c != '\0') text += c;
    }
    std::uint64_t value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if ((explicit_ && !e.is("IS")) || error != std::errc() || stop != text.data() + text.size()) {
      damaged("the number of frames is unclear");
    }
    result_.frames = value;
  }

  std::span<const std::byte> data_;
  bool explicit_;
  bool big_endian_;
  const Limits& limits_;
  std::size_t at_ = 0;
  std::uint32_t elements_ = 0;
  std::uint32_t top_ = 0;    ///< top-level element that is being walked
  std::uint32_t group_ = 0;  ///< functional group within it
  DataSet* into_;            ///< receives the elements of the current item, or null
  Walked result_;
};

}  // namespace

Walked walk(std::span<const std::byte> data, bool explicit_vr, bool big_endian,
            const Limits& limits, DataSet* tree) {
  Walker walker(data, explicit_vr, big_endian, limits, tree);
  try {
    walker.run();
  } catch (const Stop& stop) {
    walker.result().state = stop.state;
    walker.result().text = stop.text;
  }
  return std::move(walker.result());
}

}  // namespace diaphane::dicom
