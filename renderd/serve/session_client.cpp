#include "renderd/serve/session_client.h"

#include <algorithm>
#include <utility>

#include "renderd/encode/frame_mark.h"
#include "renderd/serve/session_lane.h"
#include "renderd/serve/session_turn.h"

namespace diaphane::render {
namespace {

v1::KernelReport::Origin to_proto(KernelOrigin origin) {
  switch (origin) {
    case KernelOrigin::kGeneral:
      return v1::KernelReport::GENERAL;
    case KernelOrigin::kAheadOfTime:
      return v1::KernelReport::AHEAD_OF_TIME;
    case KernelOrigin::kForThisScene:
      return v1::KernelReport::FOR_THIS_SCENE;
  }
  return v1::KernelReport::ORIGIN_UNSPECIFIED;
}

}  // namespace

ViewRequest LiveSession::Client::requested() {
  const Turn turn(session_);
  const TimePoint now = turn.now;
  if (session_.textures_ready() && session_.volume_fits()) session_.make_ready();
  session_.version_.store(session_.ready_.version, std::memory_order_relaxed);
  ViewRequest requested = session_.ready_;
  if (session_.visitor_) requested.viewport = visitor_canvas(requested.viewport);
  requested.picture_again = session_.state_.requested.picture_again;
  requested.kernel_report = session_.state_.requested.kernel_report;
  requested.visible = watched(session_.state_, now);
  requested.room =
      std::any_of(session_.lanes_.begin(), session_.lanes_.end(), [&](const auto& lane) {
        return lane->slot->slot_free() && has_room(session_.state_, lane->codec, now);
      });
  // The request of a hidden viewer is kept until the viewer returns.
  if (requested.visible) session_.state_.requested.picture_again = false;
  return requested;
}

void LiveSession::Client::began(std::uint64_t epoch, const ViewRequest& requested) {
  const std::lock_guard lock(session_.mutex_);
  render::began(session_.state_, epoch, requested);
  session_.note(session_.convergence_.began(requested.last_input, session_.parts_.clock.now()));
  session_.tiles_.handle(EpochBegan{});
}

void LiveSession::Client::refused(const ViewRequest& requested, const Error& why) {
  const Turn turn(session_);
  session_.apply_to_presenter(render::refused(session_.state_, requested, why));
}

void LiveSession::Client::rendered(const Batch& batch) {
  session_.parts_.metrics.rendered(batch.samples, batch.seconds, batch.dropped_samples);
  session_.parts_.gpu_time.add(session_.facts_.charged_to, batch.seconds + batch.helped_seconds);
  const std::lock_guard lock(session_.mutex_);
  session_.device_seconds_ += batch.seconds;
  session_.samples_since_ += batch.samples;
  session_.dropped_samples_ += batch.dropped_samples;
}

void LiveSession::Client::progressed(const Progress& progress, bool moving) {
  const std::lock_guard lock(session_.mutex_);
  session_.note(session_.convergence_.progressed(progress, moving, session_.parts_.clock.now()));
}

void LiveSession::Client::picture(RenderedPicture picture) {
  if (session_.parts_.mark_frames) draw_frame_mark(picture.picture, picture.info.input_seq);
  session_.keep_if_last(picture);
  Lanes all;
  {
    const std::lock_guard lock(session_.mutex_);
    all = session_.lanes_;
  }
  for (std::size_t i = 0; i + 1 < all.size(); ++i) all[i]->slot->submit(picture);
  if (!all.empty()) all.back()->slot->submit(std::move(picture));
}

void LiveSession::Client::kernel(const KernelReport& report) {
  v1::ServerMessage message;
  v1::KernelReport& out = *message.mutable_kernel();
  out.mutable_compiled_in()->Assign(report.compiled_in.begin(), report.compiled_in.end());
  out.mutable_left_out()->Assign(report.left_out.begin(), report.left_out.end());
  out.set_origin(to_proto(report.origin));
  out.set_compile_milliseconds(report.compile_milliseconds);
  out.set_from_cache(report.from_cache);
  if (report.registers) out.set_registers(static_cast<std::uint32_t>(*report.registers));
  const std::lock_guard lock(session_.mutex_);
  session_.state_.requested.kernel_report = false;
  for (Receiver& receiver : session_.state_.audience.receivers) {
    if (!std::exchange(receiver.kernel_wanted, false)) continue;
    // The number of empty cells describes the whole scan, not only what is shown.
    if (receiver.viewer == ViewerKind::kGuest) {
      out.clear_empty_cells();
    } else {
      out.set_empty_cells(report.empty_cells);
    }
    session_.send(receiver.connection, message);
  }
}

void LiveSession::Client::failed(const Error& why) { session_.failed(why); }

}  // namespace diaphane::render
