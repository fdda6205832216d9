#pragma once

#include <string>

#include "api/environments/environments.h"
#include "api/presets/preset_pictures.h"
#include "api/scans/data_set_store.h"
#include "api/scans/thumbnails.h"
#include "api/scans/upload_files.h"

namespace diaphane::api {

/// Deletes the files that the database has queued for deletion. Failures are retried in the next
/// run.
class Disposer {
 public:
  Disposer(DataSetStore& store, UploadFiles& files, Thumbnails& thumbnails,
           PresetPictures& preset_pictures, Environments& environments,
           std::string volume_directory, std::string export_directory)
      : store_(store),
        files_(files),
        thumbnails_(thumbnails),
        preset_pictures_(preset_pictures),
        environments_(environments),
        volume_directory_(std::move(volume_directory)),
        export_directory_(std::move(export_directory)) {}
  /// Deletes what is queued and returns the number of deleted items.
  int dispose();

 private:
  Result<void> remove(const Disposal& disposal);
  DataSetStore& store_;
  UploadFiles& files_;
  Thumbnails& thumbnails_;
  PresetPictures& preset_pictures_;
  Environments& environments_;
  std::string volume_directory_, export_directory_;
};

}  // namespace diaphane::api
