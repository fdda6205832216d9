#include "renderd/serve/still_service.h"

#include <chrono>

#include "common/ids.h"
#include "renderd/encode/encoder.h"
#include "renderd/scene/presets.h"
#include "renderd/session/state.h"

namespace diaphane::render {
namespace {

// The gateway waits for 20 s; a picture with the samples that it has by then is worth more than
// none.
constexpr std::chrono::seconds kLongestRendering{12};
// For one that nobody waits for, the gateway has 60 s.
constexpr std::chrono::seconds kLongestInBackground{45};

// Thumbnails of one volume with one seed are the same picture each time.
constexpr std::uint64_t kStillSeed = 1;

Result<Canvas> check_request(const v1::StillRequest& request) {
  if (!is_id(request.volume_id())) return fail(ErrorCode::kInvalid, "No volume id.", "volume_id");
  if (request.samples() == 0 || request.samples() > StillService::kMostSamples) {
    return fail(ErrorCode::kInvalid, "A still has 1 to 4096 samples.", "samples");
  }
  if (!(request.error() >= 0)) return fail(ErrorCode::kInvalid, "No such error.", "error");
  if (request.look_case() == v1::StillRequest::LOOK_NOT_SET) {
    return fail(ErrorCode::kInvalid, "Neither a preset nor a scene.", "look");
  }
  if (request.has_scene()) {
    if (const auto sound = check_scene(request.scene()); !sound)
      return tl::unexpected(sound.error());
  }
  v1::Viewport viewport;
  viewport.set_width(request.width());
  viewport.set_height(request.height());
  return check_viewport(viewport);
}

Result<v1::StillReply> coded(const Result<PictureRgb8>& picture, double error) {
  if (!picture) return tl::unexpected(picture.error());
  const auto encoder = make_encoder(v1::JPEG);
  if (!encoder) return tl::unexpected(encoder.error());
  auto frame = (*encoder)->encode(*picture, {Quality::kSettled, true});
  if (!frame) return tl::unexpected(frame.error());
  v1::StillReply reply;
  reply.set_jpeg(std::move(frame->data));
  reply.set_error(error);
  return reply;
}

}  // namespace

// Holds one of the `pending` places as long as it lives, and answers even when it is dropped on the
// way.
struct StillService::Order {
  v1::StillRequest request;
  Canvas canvas;
  std::shared_ptr<const std::atomic<bool>> cancelled;
  Done done;
  std::shared_ptr<std::atomic<int>> pending;
  std::chrono::steady_clock::time_point begun;

  void answer(Result<v1::StillReply> reply) {
    if (const Done call = std::exchange(done, nullptr)) call(std::move(reply));
  }
  ~Order() {
    answer(fail(ErrorCode::kUnavailable, "The picture was not rendered."));
    --*pending;
  }
};

void StillService::render(const v1::StillRequest& request,
                          std::shared_ptr<const std::atomic<bool>> cancelled, Done done) {
  const auto canvas = check_request(request);
  if (!canvas) return done(tl::unexpected(canvas.error()));
  if (++*pending_ > kPending) {
    --*pending_;
    return done(fail(ErrorCode::kTooMany, "Enough pictures are being rendered; try again."));
  }
  std::shared_ptr<Order> order(
      new Order{request, *canvas, std::move(cancelled), std::move(done), pending_, clock_.now()});
  volumes_.get(request.volume_id(), [this, order](Result<VolumeCache::Handle> volume) {
    begin(order, std::move(volume));
  });
}

void StillService::begin(std::shared_ptr<Order> order, Result<VolumeCache::Handle> volume) {
  if (!volume) return order->answer(tl::unexpected(volume.error()));
  StillJob job;
  if (order->request.has_scene()) {
    job.scene = std::make_shared<const v1::Scene>(order->request.scene());
  } else {
    const auto preset = preset_for((*volume)->header(), order->request.preset());
    if (!preset) return order->answer(tl::unexpected(preset.error()));
    job.scene = std::make_shared<const v1::Scene>(preset->scene());
  }
  auto renderer = engine_.renderer(*volume, kStillSeed, 0, kLiveMethod);
  if (!renderer) return order->answer(tl::unexpected(renderer.error()));
  job.renderer = std::move(*renderer);
  job.canvas = order->canvas;
  job.samples = order->request.samples();
  job.error = order->request.error();
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
  runner_.submit(std::move(job));
}

}  // namespace diaphane::render
