#include "ingest/build/read_image.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkExecutive.h>
#include <vtkImageImport.h>
#include <vtkImageReader2.h>
#include <vtkInformation.h>
#include <vtkMatrix4x4.h>
#include <vtkMetaImageReader.h>
#include <vtkNIFTIImageReader.h>
#include <vtkNew.h>
#include <vtkNrrdReader.h>
#include <vtkObject.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <new>

#include "common/try.h"
#include "ingest/build/image_header.h"
#include "ingest/build/image_volume.h"
#include "ingest/build/nifti.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

using Axes = std::array<double, 9>;

std::string lower_name(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

bool is_meta(const std::string& name) { return name.ends_with(".mha") || name.ends_with(".mhd"); }
bool is_nifti_name(const std::string& name) {
  return name.ends_with(".nii") || name.ends_with(".nii.gz");
}
bool is_nrrd(const std::string& name) { return name.ends_with(".nrrd"); }

/// Runs a reader and turns VTK's messages into an error instead of text on standard error.
class Reading {
 public:
  explicit Reading(vtkImageReader2* reader) : reader_(reader) {
    vtkObject::GlobalWarningDisplayOff();
    note_->SetClientData(&failed_);
    note_->SetCallback(
        [](vtkObject*, unsigned long, void* failed, void*) { *static_cast<bool*>(failed) = true; });
    reader->AddObserver(vtkCommand::ErrorEvent, note_);
    reader->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, note_);
  }

  Result<void> read(const std::string& path) {
    if (reader_->CanReadFile(path.c_str()) == 0) {
      return fail(ErrorCode::kInvalid, "the file type does not match its extension");
    }
    reader_->SetFileName(path.c_str());
    reader_->UpdateInformation();
    if (failed_) return fail(ErrorCode::kInvalid, "cannot read the header of the image");
    const int* extent = reader_->GetDataExtent();
    std::uint64_t voxels = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t side = std::int64_t{extent[2 * axis + 1]} - extent[2 * axis] + 1;
      if (side < 1) return fail(ErrorCode::kInvalid, "the image is empty");
      if (side > volume::kMaxSide) return fail(ErrorCode::kTooLarge, "the image is too large");
      voxels *= static_cast<std::uint64_t>(side);
    }
    if (voxels > volume::kMaxVoxels) return fail(ErrorCode::kTooLarge, "the image is too large");
    try {
      reader_->Update();
    } catch (const std::bad_alloc&) {
      return fail(ErrorCode::kOutOfMemory, "the image does not fit in memory");
    }
    if (failed_ || reader_->GetErrorCode() != 0 || reader_->GetOutput() == nullptr ||
        reader_->GetOutput()->GetScalarPointer() == nullptr) {
      return fail(ErrorCode::kInvalid, "the image is damaged or incomplete");
    }
    return {};
  }

 private:
  vtkImageReader2* reader_;
  vtkNew<vtkCallbackCommand> note_;
  bool failed_ = false;
};

Axes straight(const double* spacing) {
  return {std::abs(spacing[0]), 0, 0, 0, std::abs(spacing[1]), 0, 0, 0, std::abs(spacing[2])};
}

std::uint64_t bytes_of(vtkImageData* image) {
  return static_cast<std::uint64_t>(image->GetNumberOfPoints()) *
         static_cast<std::uint64_t>(image->GetScalarSize()) *
         static_cast<std::uint64_t>(image->GetNumberOfScalarComponents());
}

Result<volume::Volume> read_meta(const std::string& path) {
  auto axes = meta_image_axes(path);
  DIAPHANE_TRY(axes);
  vtkNew<vtkMetaImageReader> reader;
  DIAPHANE_TRY(Reading(reader).read(path));
  if (!meta_image_is_complete(path, bytes_of(reader->GetOutput()))) {
    return fail(ErrorCode::kInvalid, "the image is damaged or incomplete");
  }
  std::vector<std::string> repairs;
  if (!*axes) repairs.emplace_back(kNoAxes);
  auto volume = to_volume(reader->GetOutput(), axes->value_or(straight(reader->GetDataSpacing())),
                          1, 0, std::move(repairs));
  const std::string modality = reader->GetModality() != nullptr ? reader->GetModality() : "";
  if (volume && modality == "CT") volume->header.modality = volume::Modality::kCt;
  if (volume && modality == "MR") volume->header.modality = volume::Modality::kMr;
  return volume;
}

/// Reads a NIfTI file with phases, which VTK's reader does not read as such.
Result<volume::Volume> read_phases(const std::string& path) {
  const auto file = unpacked_file(path);
  DIAPHANE_TRY(file);
  if (!is_nifti(*file)) {
    return fail(ErrorCode::kUnsupported, "only NIfTI-1 files may have several phases");
  }
  const auto header = read_nifti_header(*file);
  DIAPHANE_TRY(header);
  return read_nifti_voxels(*file, *header);
}

Result<volume::Volume> read_nifti(const std::string& path) {
  vtkNew<vtkNIFTIImageReader> reader;
  DIAPHANE_TRY(Reading(reader).read(path));
  if (reader->GetTimeDimension() > 1) return read_phases(path);
  vtkMatrix4x4* matrix =
      reader->GetSFormMatrix() != nullptr ? reader->GetSFormMatrix() : reader->GetQFormMatrix();
  Axes axes = straight(reader->GetDataSpacing());
  std::vector<std::string> repairs;
  std::optional<std::array<double, 3>> origin;
  if (matrix != nullptr) {
    // Converts from NIfTI's right-anterior frame to LPS.
    origin = {-matrix->GetElement(0, 3), -matrix->GetElement(1, 3), matrix->GetElement(2, 3)};
    for (int row = 0; row < 3; ++row) {
      for (int axis = 0; axis < 3; ++axis) {
        axes[static_cast<std::size_t>(3 * row + axis)] =
            matrix->GetElement(row, axis) * reader->GetDataSpacing()[axis];
      }
    }
  } else {
    repairs.emplace_back(kNoAxes);
  }
  const double slope = reader->GetRescaleSlope();
  const bool scaled = std::isfinite(slope) && slope != 0;
  return to_volume(reader->GetOutput(), ras_to_lps(axes), scaled ? slope : 1,
                   scaled ? reader->GetRescaleIntercept() : 0, std::move(repairs), origin);
}

/// Returns an image over voxels that were unpacked by read_packed_nrrd.
vtkSmartPointer<vtkImageImport> image_of(PackedNrrd& packed) {
  auto import = vtkSmartPointer<vtkImageImport>::New();
  import->SetImportVoidPointer(packed.voxels.data(), 1);  // 1: VTK does not free the memory
  const int type = packed.type == "int16"    ? VTK_SHORT
                   : packed.type == "uint16" ? VTK_UNSIGNED_SHORT
                   : packed.type == "uint8"  ? VTK_UNSIGNED_CHAR
                   : packed.type == "int8"   ? VTK_SIGNED_CHAR
                   : packed.type == "float"  ? VTK_FLOAT
                                             : VTK_DOUBLE;
  import->SetDataScalarType(type);
  import->SetNumberOfScalarComponents(1);
  import->SetWholeExtent(0, packed.size[0] - 1, 0, packed.size[1] - 1, 0, packed.size[2] - 1);
  import->SetDataExtentToWholeExtent();
  import->Update();
  return import;
}

Result<volume::Volume> read_nrrd(const std::string& path) {
  auto axes = nrrd_axes(path);
  DIAPHANE_TRY(axes);
  vtkNew<vtkNrrdReader> reader;
  if (reader->CanReadFile(path.c_str()) == 0) {
    return fail(ErrorCode::kInvalid, "the file type does not match its extension");
  }
  auto packed = read_packed_nrrd(path);
  DIAPHANE_TRY(packed);
  if (*packed) {
    std::vector<std::string> notes;
    if (!*axes) notes.emplace_back(kNoAxes);
    return to_volume(image_of(**packed)->GetOutput(),
                     axes->value_or(straight((*packed)->spacing.data())), 1, 0, std::move(notes));
  }
  DIAPHANE_TRY(Reading(reader).read(path));
  if (!nrrd_is_complete(path, bytes_of(reader->GetOutput()))) {
    return fail(ErrorCode::kInvalid, "the image is damaged or incomplete");
  }
  std::vector<std::string> repairs;
  if (!*axes) repairs.emplace_back(kNoAxes);
  return to_volume(reader->GetOutput(), axes->value_or(straight(reader->GetDataSpacing())), 1, 0,
                   std::move(repairs));
}

}  // namespace

bool is_image_name(const std::string& path) {
  const std::string name = lower_name(path);
  return is_meta(name) || is_nifti_name(name) || is_nrrd(name);
}

Result<volume::Volume> read_image(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return fail(ErrorCode::kNotFound, "the file does not exist");
  }
  const std::string name = lower_name(path);
  if (is_meta(name)) return read_meta(path);
  if (is_nifti_name(name)) return read_nifti(path);
  if (is_nrrd(name)) return read_nrrd(path);
  return fail(ErrorCode::kUnsupported,
              "unsupported file type; use .mha, .mhd, .nii, .nii.gz or .nrrd");
}

}  // namespace diaphane::ingest
