#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <prometheus/text_serializer.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "api/stream/gateway.h"
#include "api/stream/hub.h"
#include "tests/support/api/fake_stream_parts.h"
#include "tests/support/api/test_viewer.h"

namespace diaphane::api::stream {

/// A gateway with fake dependencies, and viewers connected to it.
class GatewayTest : public testing::Test {
 protected:
  void start(const GatewayLimits& limits = {}) {
    gateway_.reset();
    registry_ = std::make_unique<prometheus::Registry>();
    auto started = Gateway::start({.public_url = "https://scans.example/"}, limits, places_,
                                  places_, places_, *registry_);
    ASSERT_TRUE(started) << started.error().message;
    gateway_ = std::move(*started);
  }
  TestViewer viewer(int receive_buffer = 0) { return TestViewer(gateway_->port(), receive_buffer); }
  /// Returns a connected viewer that has received the echo of its first message.
  std::unique_ptr<TestViewer> attached(const FakeWorker& worker,
                                       const std::string& user = new_id()) {
    auto one = std::make_unique<TestViewer>(gateway_->port());
    EXPECT_TRUE(one->enter(places_.issue(worker.address(), user)));
    one->send("hello");
    EXPECT_EQ(one->receive(), "hello");
    return one;
  }
  std::string metrics() { return prometheus::TextSerializer().Serialize(registry_->Collect()); }
  void wait_for_metric(const std::string& line) {
    for (int i = 0; i < 3000 && metrics().find(line) == std::string::npos; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_THAT(metrics(), testing::HasSubstr(line));
  }

  FakePlaces places_;
  std::unique_ptr<prometheus::Registry> registry_;
  std::unique_ptr<Gateway> gateway_;
};

}  // namespace diaphane::api::stream
