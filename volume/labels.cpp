#include "volume/labels.h"

#include <algorithm>
#include <limits>

#include "common/try.h"

namespace diaphane::volume {
namespace {

constexpr std::string_view kMagic{"DIALABEL\x01", 9};  // the last byte is the version
constexpr auto kLastOfIngest = static_cast<std::uint8_t>(kLastLabel);
using Presence = std::array<bool, kLastOfIngest + 1>;

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

/// Returns which labels mark at least one voxel, by their values. Damaged labels mark none.
Presence presence_of(const Volume& volume) {
  Presence present{};
  if (volume.labels.empty()) return present;
  const auto runs = checked_runs(volume.labels, volume.header.size);
  if (!runs) return present;
  for_each_run(*runs, [&](std::uint8_t label, std::size_t) { present[label] = true; });
  return present;
}

bool shows(const Volume& volume, Label wanted) {
  return presence_of(volume)[static_cast<std::size_t>(wanted)];
}

/// An axis of a volume: the distance of neighbours in memory, and their number.
struct Axis {
  std::size_t stride, count;
};

/// Gives voxels of value 0 the value of a neighbour along an axis.
void widen_along(Axis axis, std::vector<std::uint8_t>& voxels) {
  const std::size_t block = axis.stride * axis.count;
  std::vector<std::uint8_t> before(axis.stride), own(axis.stride);
  for (std::size_t start = 0; start + block <= voxels.size() && block > 0; start += block) {
    std::fill(before.begin(), before.end(), std::uint8_t{0});
    for (std::size_t i = 0; i < axis.count; ++i) {
      std::uint8_t* at = voxels.data() + start + i * axis.stride;
      std::copy_n(at, axis.stride, own.begin());
      const std::uint8_t* after = i + 1 < axis.count ? at + axis.stride : own.data();
      for (std::size_t k = 0; k < axis.stride; ++k) {
        const std::uint8_t near = before[k] != 0 ? before[k] : after[k];
        at[k] = at[k] != 0 ? at[k] : near;
      }
      before.swap(own);
    }
  }
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

const FoundPart* found_part(std::uint32_t number) {
  const auto found = std::find_if(kFoundParts.begin(), kFoundParts.end(),
                                  [number](const auto& part) { return part.number() == number; });
  return found == kFoundParts.end() ? nullptr : &*found;
}

std::string name_of(const LabelEntry& entry) {
  const FoundPart* part = found_part(entry.number);
  return part != nullptr && entry.name.empty() ? part->name : entry.name;
}

void list_found_labels(Volume& volume) {
  const Presence present = presence_of(volume);
  LabelSet& set = volume.label_set;
  std::array<std::uint8_t, kLastOfIngest + 1> values{};  // values in the set, or 0
  const bool is_first = set.empty();
  for (const FoundPart& part : kFoundParts) {
    const auto label = static_cast<std::size_t>(part.label);
    const bool is_listed =
        std::any_of(set.table.begin(), set.table.end(),
                    [&](const LabelEntry& entry) { return entry.number == part.number(); });
    if (!present[label] || is_listed || set.table.size() >= kMostLabels) continue;
    set.table.push_back({part.number(), {}, part.colour});
    values[label] = static_cast<std::uint8_t>(set.table.size());
  }
  if (set.empty()) return;
  if (is_first) {
    set.labels = {volume.header.size, std::vector<std::uint8_t>(volume.voxels.size())};
  }
  if (volume.labels.empty()) return;
  const auto runs = checked_runs(volume.labels, volume.header.size);
  if (!runs) return;
  auto at = set.labels.voxels.begin();
  for_each_run(*runs, [&](std::uint8_t label, std::size_t count) {
    const auto end = at + static_cast<std::ptrdiff_t>(count);
    if (values[label] != 0) std::replace(at, end, std::uint8_t{0}, values[label]);
    at = end;
  });
}

bool widen_dense_parts(Volume& volume) {
  LabelSet& set = volume.label_set;
  std::array<bool, kMostLabels + 1> dense{};
  for (std::size_t i = 0; i < set.table.size(); ++i) {
    const FoundPart* part = found_part(set.table[i].number);
    dense[i + 1] = part && (part->label == Label::kBone || part->label == Label::kVessel);
  }
  if (std::find(dense.begin(), dense.end(), true) == dense.end()) return false;
  std::vector<std::uint8_t>& voxels = set.labels.voxels;
  std::vector<std::uint8_t> wide(voxels.size());
  std::transform(voxels.begin(), voxels.end(), wide.begin(),
                 [&](std::uint8_t value) { return dense.at(value) ? value : std::uint8_t{0}; });
  const auto& size = volume.header.size;
  const std::size_t row = size[0], slice = row * size[1];
  widen_along({1, row}, wide);
  widen_along({row, size[1]}, wide);
  widen_along({slice, size[2]}, wide);
  std::transform(voxels.begin(), voxels.end(), wide.begin(), voxels.begin(),
                 [](std::uint8_t own, std::uint8_t wider) { return own != 0 ? own : wider; });
  return true;
}

Result<void> hide_surroundings(Volume& volume) {
  Result<std::string_view> runs{};
  if (!volume.labels.empty()) runs = checked_runs(volume.labels, volume.header.size);
  DIAPHANE_TRY(runs);
  const auto nothing = static_cast<std::int16_t>(volume.header.minimum);
  auto at = volume.voxels.begin();
  for_each_run(*runs, [&](std::uint8_t label, std::size_t count) {
    const auto end = at + static_cast<std::ptrdiff_t>(count);
    if (!is_body(label)) std::fill(at, end, nothing);
    at = end;
  });
  volume.surroundings_hidden = true;
  return {};
}

}  // namespace diaphane::volume
