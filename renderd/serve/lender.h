#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "common/lending.h"
#include "renderd/serve/grpc_assistants.h"
#include "renderd/serve/redis_client.h"

namespace diaphane::render {

/// Asks neighbours to help while this worker's sessions ask for more than its device has, and tells
/// the neighbours what it does for theirs (docs/adr/0033). Who is asked, common/lending.h decides.
/// Has a thread of its own; Redis hears of it only while something is borrowed, lent or wanted.
class Lender {
 public:
  struct Options {
    wire::RedisAddress redis;
    std::string worker_id;
    std::string incarnation;
    std::string address;  ///< where others find this worker
    std::string owner;    ///< only workers of the same fleet help each other
    LendingRules rules;
    std::chrono::milliseconds period{1000};
    std::function<double()> busy_seconds;               ///< of the device, since the start
    std::function<double()> lent_seconds;               ///< of these, for others' pictures
    std::function<std::size_t()> waiting;               ///< own sessions that would gain
    std::function<std::vector<std::string>()> volumes;  ///< loaded
    std::function<void(std::size_t borrowed)> told;     ///< after each look
  };

  /// `helpers` may be null: nobody is asked, only what is lent is told. It outlives this.
  Lender(Options options, GrpcAssistants* helpers);
  /// Gives all back.
  ~Lender();
  Lender(const Lender&) = delete;
  Lender& operator=(const Lender&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  /// Since the last look, of the device.
  struct Use {
    double seconds = 0, asked = 0, lent = 0, helped = 0;
  };

  void run();
  void look();
  Use use();
  std::vector<Neighbour> neighbours(const Use& use);
  void note_refusals();
  void borrow(const Lending& before);

  const Options options_;
  GrpcAssistants* const helpers_;
  RedisClient redis_;

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;

  // Of the thread alone.
  Clock::time_point since_;
  double busy_before_ = 0, lent_before_ = 0, helped_before_ = 0;
  double waited_ = 0;  ///< sessions, summed over the looks since
  std::size_t looks_ = 0;
  bool lent_told_ = false;
  Lending lending_;
  std::map<std::string, std::string> addresses_;      ///< of the neighbours that were seen last
  std::map<std::string, Clock::time_point> avoided_;  ///< by id, until when
  std::mt19937_64 random_{std::random_device{}()};
  std::thread thread_;
};

}  // namespace diaphane::render
