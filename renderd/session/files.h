#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "renderd/session/effects.h"
#include "renderd/session/events.h"
#include "renderd/session/state.h"

namespace diaphane::render {

struct KeyViewSent {
  std::uint64_t connection = 0;
  const diaphane::v1::KeyView& view;
};
struct FileMarkSent {
  std::uint64_t connection = 0;
  const diaphane::v1::FileMark& mark;
};
/// A request without a kind cancels the current file.
struct FileRequested {
  std::uint64_t connection = 0;
  const diaphane::v1::FileRequest& request;
  std::shared_ptr<const DeviceVolume> volume;  ///< null: not loaded yet
};
struct FileTaken {
  std::uint64_t connection = 0;
  std::uint64_t seq = 0;
};
/// The work on a file has a message for the viewer who asked for it.
struct FileMessage {
  std::uint64_t file = 0;
  diaphane::v1::ServerMessage message;
  bool last = false;
};
struct FileRefused {
  std::uint64_t file = 0;
  Error why;
  /// The inputs of the refused file, which are kept for the next request.
  std::vector<diaphane::v1::Scene> keys;
  std::vector<diaphane::v1::FileMark> marks;
};

/// The video or large picture that a session makes for download (docs/adr/0031), one at a time.
class Files {
 public:
  Effects handle(const KeyViewSent& event, const SessionState& state);
  Effects handle(const FileMarkSent& event, const SessionState& state);
  Effects handle(FileRequested event, const SessionState& state);
  Effects handle(const FileTaken& event, const SessionState& state);
  Effects handle(FileMessage event);
  Effects handle(FileRefused event);
  Effects handle(const ViewerLeft& event);
  Effects handle(SessionEnded event);

  /// Returns whether this file is still wanted.
  bool makes(std::uint64_t file) const { return file_ && file_->id == file; }

 private:
  Effects give_up();

  /// The file that is being made or sent.
  struct File {
    std::uint64_t id = 0;
    std::uint64_t connection = 0;  ///< connection that asked for it
  };
  std::optional<File> file_;
  std::uint64_t files_ = 0;  // number of files so far, from which ids are made
  std::vector<diaphane::v1::Scene> key_views_;
  std::vector<diaphane::v1::FileMark> marks_;
};

}  // namespace diaphane::render
