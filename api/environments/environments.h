#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "api/accounts/accounts.h"
#include "api/shared/signals.h"
#include "common/clock.h"

namespace diaphane::api {

/// A panorama that a user brought to light scans with. Its picture is a file of the volume store
/// (docs/contracts.md, "Environments") and never changes.
struct Environment {
  std::string id, owner_id;
  std::string name;
  std::string content_hash;  ///< of the uploaded file, so that an account stores it only once
  std::string preview;       ///< 32 x 16 pixels in sRGB, in hexadecimal
  std::int64_t bytes = 0;    ///< size of the stored picture
  Time created_at{};
  bool mine = false;  ///< belongs to the requesting user
};

/// Implemented by environments/environment_repository. Every function may return kUnavailable.
class EnvironmentStore {
 public:
  virtual ~EnvironmentStore() = default;
  /// Returns the owner's environments, newest first.
  virtual Result<std::vector<Environment>> of(const std::string& owner_id) = 0;
  /// Returns kNotFound if there is no environment with this ID.
  virtual Result<Environment> find(const std::string& id) = 0;
  /// Returns kTooMany if the owner would have more than `most`, and kConflict if they have one with
  /// this content.
  virtual Result<void> add(const Environment& environment, int most) = 0;
  /// Both return kNotFound also for another user's environment. remove() queues it for disposal.
  virtual Result<void> rename(const std::string& owner_id, const std::string& id,
                              const std::string& name) = 0;
  virtual Result<void> remove(const std::string& owner_id, const std::string& id) = 0;
};

/// The result of importing an uploaded file.
struct ImportedPanorama {
  std::string picture;  ///< the form in which it is stored
  std::string preview;  ///< as in Environment
};

/// Implemented by environments/panorama_child.
class PanoramaImporter {
 public:
  virtual ~PanoramaImporter() = default;
  /// May take seconds. Returns kInvalid with a sentence and, as the field, a word for what is wrong
  /// with the file; kUnavailable if it cannot be read at the moment.
  virtual Result<ImportedPanorama> import(const std::string& file) = 0;
};

/// The environments of users. This class decides who may do what: only the owner lists, renames and
/// deletes an environment and gets its name. An ID is 122 random bits that the owner gives away
/// with a scene, so whoever knows it was shown such a scene and may use the light. Nobody can
/// download the picture, except in the owner's export. Thread-safe.
class Environments {
 public:
  static constexpr int kMostEnvironments = 16;  ///< per account
  static constexpr int kMostImports = 2;        ///< at the same time; one per account
  static constexpr std::int64_t kMostUpload = 4 * 1024 * 1024;

  /// `directory` is the directory of the volume store.
  Environments(EnvironmentStore& store, PanoramaImporter& importer, const Clock& clock,
               const Signals& signals, const std::string& directory);

  Outcome<std::vector<Environment>> list(const Principal& who);
  /// Returns the environment to anyone who knows its ID, but its name only to the owner.
  Outcome<Environment> find(const Principal& who, const std::string& id);
  /// Returns the existing environment if the account already has this file. Returns kInvalid for
  /// `file`, kTooMany if the account is full or already imports a file, or kBusy.
  Outcome<Environment> add(const Principal& who, const std::string& name, const std::string& file);
  Outcome<Environment> rename(const Principal& who, const std::string& id, const std::string& name);
  Outcome<void> remove(const Principal& who, const std::string& id);
  /// Deletes the file of an environment.
  Result<void> dispose(const std::string& id);

 private:
  /// One of the kMostImports places, held while a user's import runs.
  class Place;
  Outcome<ImportedPanorama> import(const Principal& who, const std::string& file);
  std::string path_of(const std::string& id) const { return directory_ + "/" + id + ".hdr"; }

  EnvironmentStore& store_;
  PanoramaImporter& importer_;
  const Clock& clock_;
  const Signals& signals_;
  const std::string directory_;
  std::mutex mutex_;
  std::vector<std::string> importing_;  ///< IDs of the users whose import is running
};

}  // namespace diaphane::api
