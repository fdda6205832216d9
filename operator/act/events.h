#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <stop_token>
#include <thread>

#include "operator/kube/api.h"
#include "operator/kube/event_log.h"

namespace diaphane::fleet {

/// Writes Events in a separate thread, so that a slow API server delays no caller. Events that
/// cannot be written are dropped.
class Events {
 public:
  Events(kube::Api& api, std::string name_space);
  void record(kube::Happened what);

 private:
  struct Waiting {
    kube::Happened what;
    kube::EventLog::Write write;
  };
  void run(const std::stop_token& stop);
  void write(const Waiting& one);

  kube::Api& api_;
  const std::string path_;
  const std::string name_space_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  kube::EventLog log_;
  std::deque<Waiting> waiting_;
  std::jthread thread_;  // last member, because it uses the others
};

}  // namespace diaphane::fleet
