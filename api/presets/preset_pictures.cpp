#include "api/presets/preset_pictures.h"

#include <filesystem>

#include "api/shared/picture_file.h"
#include "common/log.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

namespace fs = std::filesystem;

/// Longer than a request to a worker (Stills), so that no thumbnail is rendered twice.
constexpr std::chrono::seconds kLease{90};
/// Delay before the next attempt if no worker responded.
constexpr std::chrono::seconds kPause{10};

std::string path_of(const std::string& preset_id) {
  return "presets/" + preset_id + "/picture.jpg";
}

tl::unexpected<Problem> none_yet() {
  return refuse(ProblemKind::kNotFound, "This preset has no preview image yet.");
}

}  // namespace

Outcome<std::string> PresetPictures::get(const Principal& who, const std::string& data_set_id,
                                         const std::string& preset_id) {
  const auto preset = presets_.find(who, preset_id);
  DIAPHANE_TRY(preset);
  if (preset->data_set_id != data_set_id) {
    return refuse(ProblemKind::kNotFound, "Preset not found.");
  }
  const auto data_set = data_sets_.find_ready(who, data_set_id);
  if (!data_set && data_set.error().kind == ProblemKind::kNotReady) return none_yet();
  DIAPHANE_TRY(data_set);
  if (!preset->pictured_at) return none_yet();
  std::error_code error;
  std::string path = path_of(preset_id);
  if (!fs::exists(directory_ + "/" + path, error)) {
    // The cache may have lost the file.
    (void)store_.forget_picture(preset_id);
    return none_yet();
  }
  DIAPHANE_TRY(data_sets_.note_picture(who, *data_set));
  return path;
}

bool PresetPictures::make_next() {
  const auto next = store_.claim_picture(clock_.wall(), kLease);
  if (!next || !*next) return false;
  const PresetPicture& picture = **next;
  StillRequest request;
  request.data_set_id = picture.data_set_id;
  request.scene = scene_bytes_(picture.scene);
  request.background = true;
  // A scene that cannot be parsed, such as one of a newer version, gets no thumbnail.
  if (request.scene.empty()) return true;
  const auto jpeg = stills_.render(request);
  if (!jpeg) {
    if (jpeg.error().code != ErrorCode::kUnavailable) return true;
    (void)store_.postpone_picture(picture.preset_id, clock_.wall() + kPause);
    return false;
  }
  const auto kept = store_.keep_picture(picture, clock_.wall(), [&] {
    return write_picture(directory_ + "/" + path_of(picture.preset_id), *jpeg);
  });
  if (!kept)
    log::warning("failed to save a preset's preview image", {{"preset", picture.preset_id}});
  return kept.has_value();
}

Result<void> PresetPictures::remove(const std::string& preset_id) {
  std::error_code error;
  fs::remove_all(fs::path(directory_ + "/" + path_of(preset_id)).parent_path(), error);
  if (error) return fail(ErrorCode::kUnavailable, "cannot delete the image");
  return {};
}

}  // namespace diaphane::api
