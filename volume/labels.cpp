#include "volume/labels.h"

#include <algorithm>
#include <limits>

#include "common/try.h"

namespace diaphane::volume {
namespace {

constexpr std::string_view kMagic{"DIALABEL\x01", 9};  // the last byte is the version
constexpr std::array<std::uint8_t, 3> kBrainColour{222, 178, 160};
constexpr auto kLastOfIngest = static_cast<std::uint8_t>(Label::kBrain);

void append_number(std::string& bytes, std::uint64_t number) {
  while (number >= 0x80) {
    bytes.push_back(static_cast<char>((number & 0x7f) | 0x80));
    number >>= 7;
  }
  bytes.push_back(static_cast<char>(number));
}

/// Takes a LEB128 number from the front of `bytes`. Returns false if it is cut off or has more than
/// 63 bits.
bool take_number(std::string_view& bytes, std::uint64_t& number) {
  number = 0;
  for (unsigned shift = 0; shift < 63 && !bytes.empty(); shift += 7) {
    const auto byte = static_cast<std::uint8_t>(bytes.front());
    bytes.remove_prefix(1);
    number |= std::uint64_t{byte & 0x7fU} << shift;
    if (byte < 0x80) return true;
  }
  return false;
}

tl::unexpected<Error> invalid(const char* text) { return fail(ErrorCode::kInvalid, text); }

Result<std::size_t> voxels_of(const std::array<std::uint32_t, 3>& size) {
  const std::uint64_t area = std::uint64_t{size[0]} * size[1];
  if (size[2] != 0 && area > std::numeric_limits<std::size_t>::max() / size[2]) {
    return invalid("The size of the labels is too large.");
  }
  return static_cast<std::size_t>(area * size[2]);
}

/// Calls `each` with the label and the length of every run. Precondition: checked_runs accepted
/// the bytes.
template <typename Each>
void for_each_run(std::string_view runs, Each each) {
  while (!runs.empty()) {
    const auto label = static_cast<std::uint8_t>(runs.front());
    runs.remove_prefix(1);
    std::uint64_t count = 0;
    take_number(runs, count);
    each(label, static_cast<std::size_t>(count));
  }
}

/// Checks encoded labels and returns their runs. Allocates nothing, so that damaged bytes cost no
/// memory.
Result<std::string_view> checked_runs(std::string_view bytes, std::array<std::uint32_t, 3> size,
                                      std::uint8_t most = kLastOfIngest) {
  if (!bytes.starts_with(kMagic)) return invalid("These are not labels of this version.");
  bytes.remove_prefix(kMagic.size());
  for (const std::uint32_t side : size) {
    std::uint64_t stored = 0;
    if (!take_number(bytes, stored)) return invalid("The labels are cut off.");
    if (stored != side) return invalid("The labels belong to a volume of another size.");
  }
  const auto voxels = voxels_of(size);
  DIAPHANE_TRY(voxels);
  std::uint64_t left = *voxels;
  for (std::string_view rest = bytes; !rest.empty();) {
    const auto label = static_cast<std::uint8_t>(rest.front());
    rest.remove_prefix(1);
    std::uint64_t count = 0;
    if (!take_number(rest, count)) return invalid("The labels are cut off.");
    if (label > most) return invalid("A label is unknown.");
    if (count == 0 || count > left) return invalid("A run of labels has an invalid length.");
    left -= count;
  }
  if (left != 0) return invalid("The labels are cut off.");
  return bytes;
}

bool shows(const Volume& volume, Label wanted) {
  const auto runs = checked_runs(volume.labels, volume.header.size);
  bool found = false;
  if (runs) {
    for_each_run(*runs, [&](std::uint8_t label, std::size_t count) {
      found = found || (count > 0 && label == static_cast<std::uint8_t>(wanted));
    });
  }
  return found;
}

}  // namespace

std::string encode(const Labels& labels) {
  std::string bytes{kMagic};
  for (const std::uint32_t side : labels.size) append_number(bytes, side);
  const auto end = labels.voxels.end();
  for (auto at = labels.voxels.begin(); at != end;) {
    const auto stop = std::find_if(at, end, [&](std::uint8_t label) { return label != *at; });
    bytes.push_back(static_cast<char>(*at));
    append_number(bytes, static_cast<std::uint64_t>(stop - at));
    at = stop;
  }
  return bytes;
}

Result<Labels> decode(std::string_view bytes, std::array<std::uint32_t, 3> size,
                      std::uint8_t most) {
  const auto runs = checked_runs(bytes, size, most);
  DIAPHANE_TRY(runs);
  Labels labels{size, {}};
  labels.voxels.reserve(*voxels_of(size));
  for_each_run(*runs, [&](std::uint8_t label, std::size_t count) {
    labels.voxels.insert(labels.voxels.end(), count, label);
  });
  return labels;
}

Result<void> check_labels(std::string_view bytes, std::array<std::uint32_t, 3> size) {
  DIAPHANE_TRY(checked_runs(bytes, size));
  return {};
}

std::uint64_t most_label_bytes(const Header& header) {
  constexpr std::uint64_t kBytesOfNumber = 5;
  return kMagic.size() + 3 * kBytesOfNumber + 2 * header.voxel_count();
}

bool has_support(const Volume& volume) { return shows(volume, Label::kSupport); }
bool has_brain(const Volume& volume) { return shows(volume, Label::kBrain); }

void list_found_labels(Volume& volume) {
  LabelSet& set = volume.label_set;
  if (set.table.size() >= kMostLabels || !has_brain(volume)) return;
  if (set.empty()) {
    set.labels = {volume.header.size, std::vector<std::uint8_t>(volume.voxels.size())};
  }
  set.table.push_back({kBrainNumber, {}, kBrainColour});
  const auto value = static_cast<std::uint8_t>(set.table.size());
  auto at = set.labels.voxels.begin();
  for_each_run(*checked_runs(volume.labels, volume.header.size),
               [&](std::uint8_t label, std::size_t count) {
                 const auto end = at + static_cast<std::ptrdiff_t>(count);
                 if (label == static_cast<std::uint8_t>(Label::kBrain)) {
                   std::replace(at, end, std::uint8_t{0}, value);
                 }
                 at = end;
               });
}

Result<void> hide_surroundings(Volume& volume) {
  Result<std::string_view> runs{};
  if (!volume.labels.empty()) runs = checked_runs(volume.labels, volume.header.size);
  DIAPHANE_TRY(runs);
  const auto nothing = static_cast<std::int16_t>(volume.header.minimum);
  auto at = volume.voxels.begin();
  for_each_run(*runs, [&](std::uint8_t label, std::size_t count) {
    const auto end = at + static_cast<std::ptrdiff_t>(count);
    const bool hides = label == static_cast<std::uint8_t>(Label::kOutside) ||
                       label == static_cast<std::uint8_t>(Label::kSupport);
    if (hides) std::fill(at, end, nothing);
    at = end;
  });
  volume.surroundings_hidden = true;
  return {};
}

}  // namespace diaphane::volume
