#include "ingest/cli/sample/cranium.h"

#include <archive.h>
#include <archive_entry.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>

namespace diaphane::sample {
namespace {

volume::Volume plain(const Cranium& cranium) {
  volume::Volume volume;
  volume.header.size = cranium.size;
  volume.header.spacing = cranium.spacing;
  return volume;
}

}  // namespace

Result<Cranium> read_cranium(const std::string& path) {
  if (!std::filesystem::exists(path)) {
    return fail(ErrorCode::kNotFound,
                "the cranium data set is missing. Install Debian's invesalius-examples package (" +
                    path + ")");
  }
  const std::unique_ptr<archive, int (*)(archive*)> in(archive_read_new(), archive_read_free);
  archive_read_support_filter_gzip(in.get());
  archive_read_support_format_tar(in.get());
  if (archive_read_open_filename(in.get(), path.c_str(), 1 << 16) != ARCHIVE_OK) {
    return fail(ErrorCode::kInvalid, "this is not an InVesalius project");
  }
  Cranium cranium;
  cranium.matrix.resize(std::size_t{cranium.size[0]} * cranium.size[1] * cranium.size[2]);
  const std::size_t bytes = cranium.matrix.size() * sizeof(std::int16_t);
  archive_entry* entry = nullptr;
  while (archive_read_next_header(in.get(), &entry) == ARCHIVE_OK) {
    const char* name = archive_entry_pathname(entry);
    if (name == nullptr || !std::string_view(name).ends_with("/matrix.dat")) continue;
    if (archive_entry_size(entry) != static_cast<la_int64_t>(bytes) ||
        archive_read_data(in.get(), cranium.matrix.data(), bytes) !=
            static_cast<la_ssize_t>(bytes)) {
      break;
    }
    return cranium;
  }
  return fail(ErrorCode::kInvalid, "this is not the cranium of invesalius-examples");
}

volume::Volume upright(const Cranium& cranium) {
  volume::Volume volume = plain(cranium);
  volume.header.modality = volume::Modality::kCt;
  volume.header.window_center = -18;  // the window of the InVesalius project
  volume.header.window_width = 406;
  const auto [nx, ny, nz] = cranium.size;
  volume.voxels.resize(cranium.matrix.size());
  for (std::uint32_t z = 0; z < nz; ++z) {
    for (std::uint32_t y = 0; y < ny; ++y) {
      const auto from =
          cranium.matrix.begin() + std::size_t{nx} * (std::size_t{ny} * z + (ny - 1 - y));
      const auto to = volume.voxels.begin() + std::size_t{nx} * (std::size_t{ny} * z + y);
      std::copy(from, from + nx, to);
    }
  }
  volume::measure(volume);
  return volume;
}

volume::Volume mapped(const Cranium& cranium) {
  volume::Volume volume = plain(cranium);
  volume.header.modality = volume::Modality::kOther;
  volume.header.window_center = 15000;
  volume.header.window_width = 30000;
  volume.voxels.reserve(cranium.matrix.size());
  for (const std::int16_t hu : cranium.matrix) {
    const double share = std::clamp((hu - 150) / 450.0, 0.0, 1.0);
    volume.voxels.push_back(static_cast<std::int16_t>(std::lround(30000 * share)));
  }
  volume::measure(volume);
  return volume;
}

Result<void> write_mha(const volume::Volume& volume, const std::string& path) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  const auto& h = volume.header;
  out.precision(10);
  out << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      << "CompressedData = False\nTransformMatrix =";
  // MetaImage lists the axes one after another, which are the columns of the volume's direction.
  for (int axis = 0; axis < 3; ++axis) {
    for (int row = 0; row < 3; ++row)
      out << ' ' << h.direction[static_cast<std::size_t>(3 * row + axis)];
  }
  out << "\nOffset = 0 0 0\nCenterOfRotation = 0 0 0\nAnatomicalOrientation = RAI\nElementSpacing "
         "= "
      << h.spacing[0] << ' ' << h.spacing[1] << ' ' << h.spacing[2] << "\nDimSize = " << h.size[0]
      << ' ' << h.size[1] << ' ' << h.size[2]
      << "\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
  out.write(reinterpret_cast<const char*>(volume.voxels.data()),
            static_cast<std::streamsize>(volume.voxels.size() * sizeof(std::int16_t)));
  out.close();
  if (!out) return fail(ErrorCode::kUnavailable, "cannot write the file " + path);
  return {};
}

}  // namespace diaphane::sample
