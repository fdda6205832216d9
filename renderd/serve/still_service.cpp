#include "renderd/serve/still_service.h"

#include <algorithm>
#include <chrono>

#include "common/ids.h"
#include "common/try.h"
#include "renderd/encode/encoder.h"
#include "renderd/scene/presets.h"
#include "renderd/session/state.h"

namespace diaphane::render {
namespace {

// The gateway waits for 20 s. A picture with the samples rendered by then is better than none.
constexpr std::chrono::seconds kLongestRendering{12};
// For a background picture, the gateway allows 60 s.
constexpr std::chrono::seconds kLongestInBackground{45};

// With a fixed seed, thumbnails of one volume are always the same picture.
constexpr std::uint64_t kStillSeed = 1;

Result<Canvas> check_request(const v1::StillRequest& request) {
  if (!is_id(request.volume_id()))
    return fail(ErrorCode::kInvalid, "The volume ID is missing or invalid.", "volume_id");
  if (request.samples() == 0 || request.samples() > StillService::kMostSamples) {
    return fail(ErrorCode::kInvalid, "The number of samples must be from 1 to 4096.", "samples");
  }
  if (!(request.error() >= 0))
    return fail(ErrorCode::kInvalid, "The error must be 0 or greater.", "error");
  if (request.look_case() == v1::StillRequest::LOOK_NOT_SET) {
    return fail(ErrorCode::kInvalid, "A preset or a scene is required.", "look");
  }
  if (request.has_scene()) {
    DIAPHANE_TRY(check_scene(request.scene()));
  }
  v1::Viewport viewport;
  viewport.set_width(request.width());
  viewport.set_height(request.height());
  return check_viewport(viewport);
}

Result<v1::StillReply> coded(const Result<PictureRgb8>& picture, double error) {
  DIAPHANE_TRY(picture);
  const auto encoder = make_encoder(v1::JPEG);
  DIAPHANE_TRY(encoder);
  auto frame = (*encoder)->encode(*picture, {Quality::kSettled, true});
  DIAPHANE_TRY(frame);
  v1::StillReply reply;
  reply.set_jpeg(std::move(frame->data));
  reply.set_error(error);
  return reply;
}

}  // namespace

// Holds one of the `pending` places during its lifetime, and answers even when it is dropped.
struct StillService::Order {
  v1::StillRequest request;
  Canvas canvas;
  std::shared_ptr<const std::atomic<bool>> cancelled;
  Done done;
  std::shared_ptr<std::atomic<int>> pending;
  std::chrono::steady_clock::time_point begun;
  std::shared_ptr<const Home> home = nullptr;  ///< chosen once the volume is loaded

  void answer(Result<v1::StillReply> reply) {
    if (const Done call = std::exchange(done, nullptr)) call(std::move(reply));
  }
  ~Order() {
    answer(fail(ErrorCode::kUnavailable, "The image could not be rendered."));
    --*pending;
  }
};

void StillService::render(const v1::StillRequest& request,
                          std::shared_ptr<const std::atomic<bool>> cancelled, Done done) {
  const auto canvas = check_request(request);
  if (!canvas) return done(tl::unexpected(canvas.error()));
  if (++*pending_ > kPending) {
    --*pending_;
    return done(
        fail(ErrorCode::kTooMany,
             "Too many images are being rendered right now. Please try again in a moment."));
  }
  std::shared_ptr<Order> order(
      new Order{request, *canvas, std::move(cancelled), std::move(done), pending_, clock_.now()});
  volumes_.get(
      {request.volume_id(), request.scene().show_table(), request.scene().volume_phase()},
      [this, order](Result<VolumeCache::Handle> volume) { begin(order, std::move(volume)); });
}

void StillService::begin(std::shared_ptr<Order> order, Result<VolumeCache::Handle> volume) {
  if (!volume) return order->answer(tl::unexpected(volume.error()));
  StillJob job;
  if (order->request.has_scene()) {
    job.scene = std::make_shared<const v1::Scene>(order->request.scene());
  } else {
    const auto preset = preset_for((*volume)->header(), stats_.framing_of(**volume),
                                   order->request.preset(), stats_.of(**volume).brain);
    if (!preset) return order->answer(tl::unexpected(preset.error()));
    job.scene = std::make_shared<const v1::Scene>(preset->scene());
  }
  order->home = homes_.take();
  auto renderer = order->home->engine.renderer(*volume, kStillSeed, 0, kLiveMethod);
  if (!renderer) return order->answer(tl::unexpected(renderer.error()));
  job.renderer = std::move(*renderer);
  job.canvas = order->canvas;
  job.samples = std::min(order->request.samples(), most_samples_);
  job.error = order->request.error();
  job.smoothed = true;
  const bool background = order->request.background();
  job.rank = background ? StillRank::kBackground : StillRank::kAwaited;
  job.until = order->begun + (background ? kLongestInBackground : kLongestRendering);
  job.cancelled = [order] { return order->cancelled->load(); };
  job.done = [this, order](Result<PictureRgb8> picture, double error) {
    encoders_.post(EncodePool::Urgency::kLater, [this, order, picture = std::move(picture), error] {
      order->answer(coded(picture, error));
      metrics_.still(std::chrono::duration<double>(clock_.now() - order->begun).count());
    });
  };
  order->home->runner.submit(std::move(job));
}

}  // namespace diaphane::render
