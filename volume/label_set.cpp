#include "volume/label_set.h"

#include <algorithm>
#include <cmath>

#include "common/try.h"
#include "common/utf8.h"
#include "volume/labels.h"
#include "volume/volume.h"

namespace diaphane::volume {
namespace {

constexpr std::string_view kSetMagic{"DIALSETS\x01", 9};  // the last byte is the version

tl::unexpected<Error> invalid_set(const char* text) { return fail(ErrorCode::kInvalid, text); }

void append_u32(std::string& bytes, std::uint32_t number) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(number >> shift));
}

/// Takes a number of four bytes from the front of `bytes`. Returns false if it is cut off.
bool take_u32(std::string_view& bytes, std::uint32_t& number) {
  if (bytes.size() < 4) return false;
  number = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    number |= std::uint32_t{static_cast<std::uint8_t>(bytes[i])} << (8 * i);
  }
  bytes.remove_prefix(4);
  return true;
}

/// Takes an entry from the front of `bytes`: number, colour, length of the name, name.
Result<LabelEntry> take_entry(std::string_view& bytes) {
  LabelEntry entry;
  if (!take_u32(bytes, entry.number) || bytes.size() < 4) {
    return invalid_set("The table of labels is cut off.");
  }
  for (std::size_t i = 0; i < 3; ++i) entry.colour[i] = static_cast<std::uint8_t>(bytes[i]);
  const auto length = static_cast<std::uint8_t>(bytes[3]);
  bytes.remove_prefix(4);
  if (length > bytes.size()) return invalid_set("The table of labels is cut off.");
  entry.name = bytes.substr(0, length);
  bytes.remove_prefix(length);
  if (entry.number == 0 || entry.name != clean_label_name(entry.name)) {
    return invalid_set("An entry of the table of labels is invalid.");
  }
  return entry;
}

}  // namespace

std::array<std::uint8_t, 3> label_colour(std::size_t index) {
  // Hues that are a golden section apart never repeat and are evenly spread at any number. Every
  // second colour is paler, because neighbours in the table are often neighbours in the body.
  const double hue = 6 * std::fmod(0.02 + 0.61803398875 * static_cast<double>(index), 1.0);
  const double saturation = index % 2 == 0 ? 0.75 : 0.5;
  std::array<std::uint8_t, 3> colour{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double distance = std::abs(std::fmod(hue - 2 * static_cast<double>(i) + 9, 6.0) - 3);
    const double share = std::clamp(2 - distance, 0.0, 1.0);  // share in a saturated colour
    colour[i] = static_cast<std::uint8_t>(std::lround(230 * (1 - saturation * (1 - share))));
  }
  return colour;
}

std::string clean_label_name(std::string_view name) {
  std::string clean;
  for (const char c : name) {
    const auto byte = static_cast<std::uint8_t>(c);
    if (byte >= 0x20 && byte != 0x7f) clean.push_back(c);
  }
  const auto begin = clean.find_first_not_of(' ');
  if (begin == std::string::npos) return {};
  clean = clean.substr(begin, clean.find_last_not_of(' ') + 1 - begin);
  if (clean.size() > kLongestLabelName) {
    std::size_t end = kLongestLabelName;
    // Does not cut through a character.
    while (end > 0 && (static_cast<std::uint8_t>(clean[end]) & 0xc0) == 0x80) --end;
    clean.resize(end);
    while (!clean.empty() && clean.back() == ' ') clean.pop_back();
  }
  return is_utf8(clean) ? clean : std::string();
}

std::string encode(const LabelSet& set) {
  std::string bytes{kSetMagic};
  append_u32(bytes, static_cast<std::uint32_t>(set.table.size()));
  for (const LabelEntry& entry : set.table) {
    append_u32(bytes, entry.number);
    for (const std::uint8_t part : entry.colour) bytes.push_back(static_cast<char>(part));
    bytes.push_back(static_cast<char>(entry.name.size()));
    bytes += entry.name;
  }
  return bytes + encode(set.labels);
}

std::uint64_t most_label_set_bytes(const Header& header) {
  constexpr std::uint64_t kEntryBytes = 8 + kLongestLabelName;
  return kSetMagic.size() + 4 + kMostLabels * kEntryBytes + most_label_bytes(header);
}

Result<LabelSet> decode_label_set(std::string_view bytes, std::array<std::uint32_t, 3> size) {
  if (!bytes.starts_with(kSetMagic)) return invalid_set("This is not a label set of this version.");
  bytes.remove_prefix(kSetMagic.size());
  std::uint32_t count = 0;
  if (!take_u32(bytes, count)) return invalid_set("The table of labels is cut off.");
  if (count == 0 || count > kMostLabels) return invalid_set("The number of labels is invalid.");
  LabelSet set;
  for (std::uint32_t i = 0; i < count; ++i) {
    auto entry = take_entry(bytes);
    DIAPHANE_TRY(entry);
    const auto same = [&](const LabelEntry& other) { return other.number == entry->number; };
    if (std::any_of(set.table.begin(), set.table.end(), same)) {
      return invalid_set("Two labels have the same number.");
    }
    set.table.push_back(*std::move(entry));
  }
  auto labels = decode(bytes, size, static_cast<std::uint8_t>(count));
  DIAPHANE_TRY(labels);
  set.labels = *std::move(labels);
  return set;
}

}  // namespace diaphane::volume
