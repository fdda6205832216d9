#include <google/protobuf/util/message_differencer.h>

#include <utility>

#include "common/log.h"
#include "renderd/encode/slice_codec.h"
#include "renderd/serve/live_session.h"
#include "renderd/session/host_volume.h"
#include "renderd/session/kept_voxels.h"

// LiveSession: the exact slices beside the picture (docs/adr/0026).

namespace diaphane::render {
namespace {

bool same_clip(const std::optional<v1::Clip>& a, const std::optional<v1::Clip>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return google::protobuf::util::MessageDifferencer::Equals(*a, *b);
}

Result<std::vector<std::int16_t>> read_slice(const volume::Volume& volume,
                                             const volume::SliceStack& stack, std::uint32_t index,
                                             const std::optional<v1::Clip>& clip) {
  if (!clip) return volume::slice_of(volume, stack, index);
  return volume::clipped_slice_of(volume, stack, index, kept_by(volume.header, *clip));
}

}  // namespace

void LiveSession::receive_slices(std::uint64_t connection, const v1::SliceRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    Receiver* const receiver = state_.audience.find(connection);
    if (!receiver || !stacks_) return;  // pages do not ask before they are told of slices
    if (const auto noted = receiver->slices.replace(request, *stacks_); !noted) {
      return send_problem(connection, noted.error());
    }
    if (!voxels_ && receiver->slices.waiting()) return load_voxels();
  }
  send_slices(connection);
}

void LiveSession::load_voxels() {
  if (loading_voxels_) return;
  loading_voxels_ = true;
  // Posted, because the cache calls back immediately for loaded volumes, while the lock is held
  // here.
  parts_.slices.pool.post(EncodePool::Urgency::kNow, [weak = weak_from_this()] {
    const auto session = weak.lock();
    if (!session) return;
    session->parts_.slices.voxels.get({session->facts_.volume_id},
                                      [weak](Result<VolumeCache::Handle> loaded) {
                                        if (const auto alive = weak.lock())
                                          alive->voxels_ready(std::move(loaded));
                                      });
  });
}

void LiveSession::voxels_ready(Result<VolumeCache::Handle> loaded) {
  std::vector<std::uint64_t> connections;
  {
    const std::lock_guard lock(mutex_);
    loading_voxels_ = false;
    if (ended_) return;
    auto host = loaded ? std::dynamic_pointer_cast<const HostVolume>(*loaded) : nullptr;
    // If the volume was replaced in the store, the session is about to be notified.
    const bool same = host && host->header().content_hash == volume_->header().content_hash;
    for (Receiver& receiver : state_.audience.receivers) {
      if (!receiver.slices.waiting()) continue;
      connections.push_back(receiver.connection);
      if (same) continue;
      log::warning("slices_failed", {{"session", facts_.id}});
      receiver.slices = {};
      send_problem(receiver.connection,
                   {loaded ? ErrorCode::kUnavailable : loaded.error().code,
                    "The slices can't be shown right now. The 3D view continues.", "slices"});
    }
    if (!same) return;
    voxels_ = std::move(host);
  }
  for (const std::uint64_t connection : connections) send_slices(connection);
}

std::optional<LiveSession::SliceOrder> LiveSession::order_of(const Receiver& receiver,
                                                             const SliceDue& due) const {
  switch (slice_access(state_.audience.standing(receiver))) {
    case SliceAccess::kNone:
      break;
    case SliceAccess::kClipped:
      // The newest clip, even if no picture shows it yet.
      if (state_.wanted.scene) return SliceOrder{due, state_.wanted.scene->clip()};
      break;
    case SliceAccess::kWhole:
      return SliceOrder{due, std::nullopt};
  }
  return std::nullopt;
}

void LiveSession::send_slices(std::uint64_t connection) {
  const std::lock_guard lock(mutex_);
  Receiver* const receiver = state_.audience.find(connection);
  if (!receiver || !voxels_ || !receiver->slices.ready()) return;
  if (!state_.audience.slice_allowances.take(
          receiver->participant, receiver->viewer == ViewerKind::kGuest, parts_.clock.now())) {
    return;  // tick() tries again
  }
  const auto due = receiver->slices.take();
  if (!due) return;
  const auto order = order_of(*receiver, *due);
  if (!order) {
    receiver->slices.give_up();
    return receiver->slices.forget();
  }
  const auto urgency = receiver->viewer == ViewerKind::kGuest || visitor_
                           ? EncodePool::Urgency::kLater
                           : EncodePool::Urgency::kNow;
  parts_.slices.pool.post(urgency, [weak = weak_from_this(), connection, order = *order,
                                    stack = (*stacks_)[due->plane], voxels = voxels_] {
    if (weak.expired()) return;
    auto coded = read_slice(voxels->volume(), stack, order.due.index, order.clip)
                     .and_then([&](const auto& values) { return code_slice(values); });
    if (const auto session = weak.lock()) {
      session->slice_coded(connection, order, std::move(coded));
    }
  });
}

void LiveSession::slice_coded(std::uint64_t connection, const SliceOrder& order,
                              Result<std::string> coded) {
  {
    const std::lock_guard lock(mutex_);
    Receiver* const receiver = state_.audience.find(connection);
    if (!receiver) return;
    if (!coded) {
      receiver->slices.give_up();
      return send_problem(connection, coded.error());
    }
    // Meanwhile slices may have been switched off, or the clip may have changed.
    const auto still = order_of(*receiver, order.due);
    if (!still) {
      receiver->slices.give_up();
    } else if (!same_clip(still->clip, order.clip)) {
      receiver->slices.put_back();
    } else {
      const volume::SliceStack& stack = (*stacks_)[order.due.plane];
      v1::ServerMessage message;
      v1::ExactSlice& slice = *message.mutable_slice();
      slice.set_seq(receiver->slices.depart());
      slice.set_plane(to_proto(stack.plane));
      slice.set_index(order.due.index);
      slice.set_columns(stack.columns);
      slice.set_rows(stack.rows);
      receiver->has_clipped_slices = order.clip.has_value();
      parts_.metrics.slice_sent(coded->size());
      slice.set_data(std::move(*coded));
      send(connection, message);
    }
  }
  send_slices(connection);
}

void LiveSession::notify_stale_slices() {
  if (sliced_ == state_.wanted.scene) return;
  const auto before = std::exchange(sliced_, state_.wanted.scene);
  if (before && sliced_ && same_clip(before->clip(), sliced_->clip())) return;
  v1::ServerMessage message;
  message.mutable_slices_stale();
  for (Receiver& receiver : state_.audience.receivers) {
    if (std::exchange(receiver.has_clipped_slices, false)) send(receiver.connection, message);
  }
}

void LiveSession::send_problem(std::uint64_t connection, const Error& why) {
  v1::ServerMessage message;
  *message.mutable_problem() = problem_of(why, 0, false);
  send(connection, message);
}

}  // namespace diaphane::render
