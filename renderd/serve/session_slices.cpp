#include "common/log.h"
#include "renderd/encode/slice_codec.h"
#include "renderd/serve/live_session.h"
#include "renderd/session/host_volume.h"

// Of LiveSession: the exact slices beside the picture (docs/adr/0026).

namespace diaphane::render {

void LiveSession::receive_slices(std::uint64_t connection, const v1::SlicesWanted& wanted) {
  {
    const std::lock_guard lock(mutex_);
    Receiver* const receiver = state_.audience.find(connection);
    if (!receiver || !stacks_) return;  // nobody who was told of slices asks so early
    if (const auto noted = receiver->slices.wish(wanted, *stacks_); !noted) {
      return send_problem(connection, noted.error());
    }
    if (!voxels_ && receiver->slices.waiting()) return load_voxels();
  }
  send_slices(connection);
}

void LiveSession::load_voxels() {
  if (loading_voxels_) return;
  loading_voxels_ = true;
  // Not from within: what is there is handed over at once, and this is under the lock.
  parts_.slices.pool.post(EncodePool::Urgency::kNow, [weak = weak_from_this()] {
    const auto session = weak.lock();
    if (!session) return;
    session->parts_.slices.voxels.get(session->volume_id_,
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
    // Exchanged in the store meanwhile: the session is about to be told so.
    const bool same = host && host->header().content_hash == volume_->header().content_hash;
    for (Receiver& receiver : state_.audience.receivers) {
      if (!receiver.slices.waiting()) continue;
      connections.push_back(receiver.connection);
      if (same) continue;
      log::warning("slices_failed", {{"session", id_}});
      receiver.slices = {};
      send_problem(receiver.connection,
                   {loaded ? ErrorCode::kUnavailable : loaded.error().code,
                    "The slices cannot be shown now; the picture goes on.", "slices"});
    }
    if (!same) return;
    voxels_ = std::move(host);
  }
  for (const std::uint64_t connection : connections) send_slices(connection);
}

void LiveSession::send_slices(std::uint64_t connection) {
  const std::lock_guard lock(mutex_);
  Receiver* const receiver = state_.audience.find(connection);
  if (!receiver || !voxels_) return;
  const auto due = receiver->slices.take(parts_.clock.now());
  if (!due) return;
  parts_.slices.pool.post(
      EncodePool::Urgency::kNow, [weak = weak_from_this(), connection, due = *due,
                                  stack = (*stacks_)[due->plane], voxels = voxels_] {
        if (weak.expired()) return;
        auto coded =
            volume::slice_of(voxels->volume(), stack, due.index).and_then([&](const auto& values) {
              return code_slice(values);
            });
        if (const auto session = weak.lock()) {
          session->slice_coded(connection, due, std::move(coded));
        }
      });
}

void LiveSession::slice_coded(std::uint64_t connection, const SliceDue& due,
                              Result<std::string> coded) {
  {
    const std::lock_guard lock(mutex_);
    Receiver* const receiver = state_.audience.find(connection);
    if (!receiver) return;
    if (!coded) {
      receiver->slices.give_up();
      return send_problem(connection, coded.error());
    }
    const volume::SliceStack& stack = (*stacks_)[due.plane];
    v1::ServerMessage message;
    v1::ExactSlice& slice = *message.mutable_slice();
    slice.set_seq(receiver->slices.depart());
    slice.set_plane(to_proto(stack.plane));
    slice.set_index(due.index);
    slice.set_columns(stack.columns);
    slice.set_rows(stack.rows);
    parts_.metrics.slice_sent(coded->size());
    slice.set_data(std::move(*coded));
    send(connection, message);
  }
  send_slices(connection);
}

void LiveSession::send_problem(std::uint64_t connection, const Error& why) {
  v1::ServerMessage message;
  *message.mutable_problem() = problem_of(why, 0, false);
  send(connection, message);
}

}  // namespace diaphane::render
