#include "api/stream/hub.h"

#include "common/log.h"

namespace diaphane::api::stream {

bool Hub::enter(const std::shared_ptr<Connection>& connection) {
  const std::lock_guard lock(mutex_);
  const bool room = connections_.size() < limits.connections;
  // Even a refused connection is added, because shutdown waits for all connections.
  connections_.emplace(connection.get(), connection);
  metrics.connection_opened();
  return room;
}

void Hub::leave(Connection* connection) {
  const std::lock_guard lock(mutex_);
  if (connections_.erase(connection) == 0) return;
  metrics.connection_closed();
  if (connections_.empty()) empty_.notify_all();
}

std::vector<std::shared_ptr<Connection>> Hub::connections() const {
  std::vector<std::shared_ptr<Connection>> all;
  const std::lock_guard lock(mutex_);
  all.reserve(connections_.size());
  for (const auto& [key, known] : connections_) {
    if (auto connection = known.lock()) all.push_back(std::move(connection));
  }
  return all;
}

bool Hub::wait_until_empty(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return empty_.wait_for(lock, timeout, [&] { return connections_.empty(); });
}

namespace {

// Guests do not count as the owner of the session. Otherwise, they could lock the owner out.
std::string counted_as(const Attachment& attachment) {
  return attachment.link.empty() ? attachment.session.user_id : "guests:" + attachment.session.id;
}

}  // namespace

bool Hub::enter_user(const Attachment& attachment) {
  const std::lock_guard lock(mutex_);
  std::size_t& count = users_[counted_as(attachment)];
  const std::size_t most =
      attachment.link.empty() ? limits.connections_per_user : limits.guests_per_session;
  if (count >= most) return false;
  ++count;
  return true;
}

void Hub::leave_user(const Attachment& attachment) {
  const std::lock_guard lock(mutex_);
  const auto found = users_.find(counted_as(attachment));
  if (found != users_.end() && --found->second == 0) users_.erase(found);
}

void Hub::worker_broke_off(const Attachment& attachment) {
  if (accepts_connections(attachment.address, limits.probe)) return;
  // If Redis is unavailable, no session can be placed on the worker anyway.
  if (!workers.lost(attachment.session.worker_id, attachment.incarnation).value_or(false)) return;
  metrics.worker_lost();
  log::warning("worker_lost", {{"worker", attachment.session.worker_id}});
}

}  // namespace diaphane::api::stream
