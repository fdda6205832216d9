#include "ingest/build/meta_image.h"

#include <vtkmetaio/metaImage.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <map>
#include <new>
#include <optional>
#include <span>
#include <sstream>

#include "common/try.h"

namespace diaphane::ingest {
namespace {

/// Catches the messages of the library, which contain names of files. For a file that ends early,
/// a message is the library's only sign of an error.
class Messages {
 public:
  Messages() : out_(std::cout.rdbuf(text_.rdbuf())), err_(std::cerr.rdbuf(text_.rdbuf())) {}
  ~Messages() {
    std::cout.rdbuf(out_);
    std::cerr.rdbuf(err_);
  }
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;

  bool any() const { return !text_.str().empty(); }

 private:
  std::ostringstream text_;
  std::streambuf* out_;
  std::streambuf* err_;
};

/// A MetaImage that knows which fields its file has. The library replaces missing ones by defaults.
class MetaFile : public vtkmetaio::MetaImage {
 public:
  bool has(const char* field) const {
    return std::any_of(m_Fields.begin(), m_Fields.end(), [&](const auto* one) {
      return one->defined && std::strcmp(one->name, field) == 0;
    });
  }
};

std::optional<VoxelType> meta_type(vtkmetaio::MET_ValueEnumType type) {
  static const std::map<int, VoxelType> kMetaTypes{
      {vtkmetaio::MET_CHAR, VoxelType::kInt8},   {vtkmetaio::MET_UCHAR, VoxelType::kUint8},
      {vtkmetaio::MET_SHORT, VoxelType::kInt16}, {vtkmetaio::MET_USHORT, VoxelType::kUint16},
      {vtkmetaio::MET_INT, VoxelType::kInt32},   {vtkmetaio::MET_UINT, VoxelType::kUint32},
      {vtkmetaio::MET_FLOAT, VoxelType::kFloat}, {vtkmetaio::MET_DOUBLE, VoxelType::kDouble}};
  const auto found = kMetaTypes.find(type);
  return found == kMetaTypes.end() ? std::nullopt : std::optional(found->second);
}

Result<void> place_meta(const MetaFile& file, ImageHeader& header) {
  header.has_axes = file.has("TransformMatrix") || file.has("Rotation") || file.has("Orientation");
  for (int axis = 0; axis < file.NDims(); ++axis) {
    const double spacing = std::abs(file.ElementSpacing(axis));
    for (int row = 0; row < file.NDims(); ++row) {
      // Each axis of the file is a row of its matrix.
      const double part = header.has_axes ? file.TransformMatrix(axis, row) : axis == row ? 1 : 0;
      if (!std::isfinite(part * spacing) || (part != 0 && (axis < 3) != (row < 3)))
        return fail(ErrorCode::kInvalid, "the axes of the image are invalid");
      if (axis < 3 && row < 3)
        header.axes[static_cast<std::size_t>(3 * row + axis)] = part * spacing;
    }
  }
  if (header.has_axes) {
    const double* offset = file.Offset();
    header.origin = {offset[0], offset[1], offset[2]};
  }
  return {};
}

Result<ImageHeader> describe(const MetaFile& file) {
  ImageHeader header;
  const auto type = meta_type(file.ElementType());
  if (!type) return unknown_type();
  if (file.ElementNumberOfChannels() != 1) return several_values();
  if (file.NDims() < 3) return fail(ErrorCode::kUnsupported, "it has no depth");
  if (file.NDims() > 4) return several_values();
  header.type = *type;
  const std::array<std::int64_t, 3> size{file.DimSize(0), file.DimSize(1), file.DimSize(2)};
  DIAPHANE_TRY(set_size(header, size, file.NDims() == 4 ? file.DimSize(3) : 1, 0));
  DIAPHANE_TRY(place_meta(file, header));
  if (file.Modality() == vtkmetaio::MET_MOD_CT) header.modality = volume::Modality::kCt;
  if (file.Modality() == vtkmetaio::MET_MOD_MR) header.modality = volume::Modality::kMr;
  return header;
}

/// The library leaves the end of the voxels as it was if compressed voxels end early, so the end is
/// marked with bytes that no image has there.
constexpr std::size_t kMarkBytes = 64;
std::byte mark_at(std::size_t i) { return static_cast<std::byte>((i * 151 + 89) % 251); }
std::span<std::byte> end_of(std::vector<std::byte>& voxels) {
  return std::span(voxels).last(std::min(kMarkBytes, voxels.size()));
}

void mark_end(std::vector<std::byte>& voxels) {
  const auto end = end_of(voxels);
  for (std::size_t i = 0; i < end.size(); ++i) end[i] = mark_at(i);
}

bool has_mark(std::vector<std::byte>& voxels) {
  const auto end = end_of(voxels);
  for (std::size_t i = 0; i < end.size(); ++i) {
    if (end[i] != mark_at(i)) return false;
  }
  return true;
}

}  // namespace

Result<Image> read_meta_image(const std::string& path) {
  const Messages messages;
  MetaFile file;
  if (!MetaFile::CanRead(path.c_str())) {
    return fail(ErrorCode::kInvalid, "the file type does not match its extension");
  }
  if (!file.Read(path.c_str(), false)) {
    return fail(ErrorCode::kInvalid, "cannot read the header of the image");
  }
  auto header = describe(file);
  DIAPHANE_TRY(header);
  Image image{*std::move(header), {}};
  try {
    image.voxels.resize(image.header.voxels_bytes());
    mark_end(image.voxels);
    const bool read = file.Read(path.c_str(), true, image.voxels.data());
    if (!read || messages.any() || has_mark(image.voxels)) return damaged_image();
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "the image does not fit in memory");
  }
  file.ElementByteOrderFix();
  return image;
}

}  // namespace diaphane::ingest
