// Decodes textures of a scene in a separate thread before the runner receives the scene, because a
// lane that waited for them would render nothing for other sessions.
#include "renderd/scene/texture_store.h"
#include "renderd/serve/session_turn.h"

namespace diaphane::render {

bool LiveSession::textures_ready() {
  const std::shared_ptr<const v1::Scene> scene = state_.requested.scene;
  if (!scene || scene == decoded_) return true;
  const std::vector<TextureFile> files = texture_files(*scene);
  if (files.empty()) {
    textures_.reset();
    decoded_ = scene;
    return true;
  }
  if (decoding_) return false;
  // A free camera has the presenter's textures, which are loaded already.
  const bool bounded = visitor_ && !facts_.camera_only;
  decoding_ = true;
  parts_.textures.post(
      EncodePool::Urgency::kLater, [self = shared_from_this(), scene, bounded, before = textures_] {
        const std::vector<TextureFile> to_decode = texture_files(*scene);
        const auto small = bounded ? check_visitors_textures(to_decode) : Result<void>();
        self->textures_decoded(
            scene, small ? prepare_textures_for(self->facts_.charged_to, to_decode, before)
                         : tl::unexpected(small.error()));
      });
  return false;
}

void LiveSession::publish_version() {
  // A scene that cannot be rendered yet must not interrupt the runner.
  if (textures_ready() && volume_fits())
    version_.store(state_.requested.version, std::memory_order_relaxed);
}

void LiveSession::textures_decoded(const std::shared_ptr<const v1::Scene>& scene,
                                   Result<std::shared_ptr<const PreparedTextures>> decoded) {
  const Turn turn(*this);
  decoding_ = false;
  if (ended_) return;
  Outcome outcome;
  if (state_.requested.scene != scene) {
    // A newer scene arrived meanwhile. Its textures are decoded when the runner asks.
  } else if (decoded) {
    textures_ = std::move(*decoded);
    decoded_ = scene;
  } else {
    outcome = render::refused(state_, state_.requested, decoded.error());
    // A session that has shown nothing yet falls back to the volume's default look.
    if (state_.requested.scene == scene) {
      fallback_clip_ = scene->clip();
      state_.requested.scene.reset();  // volume_ready() chooses the look
      if (!presets_.empty()) state_.requested.scene = first_look();
    }
    ++state_.requested.version;
  }
  outcome.wake = true;
  apply_to_presenter(outcome);
}

}  // namespace diaphane::render
