#include "api/http/listener.h"

#include <cpprest/http_listener.h>
#include <pplx/threadpool.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <condition_variable>
#include <future>
#include <mutex>

#include "api/http/reason_phrase.h"
#include "common/log.h"

namespace diaphane::api {
namespace {

using web::http::http_request;
using web::http::http_response;
using web::http::experimental::listener::http_listener;

/// Maximum size of a refused body that is still read, so that the connection can be kept.
constexpr std::int64_t kSwallowBytes = 64 * 1024;

/// Maximum wait for the library to close the listener. It may lose count of a connection that ends
/// in the middle of a request, and would then wait forever.
constexpr std::chrono::milliseconds kClosePatience{500};

Head head_of(const http_request& message) {
  Head head;
  head.method = message.method();
  head.target = message.request_uri().to_string();
  for (const auto& [name, value] : message.headers()) {
    std::string lower = name;
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    head.headers.insert_or_assign(std::move(lower), value);
  }
  return head;
}

std::int64_t announced_bytes(const http_request& message) {
  const auto found = message.headers().find("Content-Length");
  if (found == message.headers().end()) return 0;
  std::int64_t length = 0;
  const std::string& text = found->second;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  return error == std::errc() ? length : INT64_MAX;
}

/// Counts requests in progress, from the head to the last byte of the response.
class InFlight {
 public:
  void enter() {
    const std::lock_guard lock(mutex_);
    ++count_;
  }
  void leave() {
    const std::lock_guard lock(mutex_);
    if (--count_ == 0) none_.notify_all();
  }
  bool wait_for_none(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return none_.wait_for(lock, patience, [this] { return count_ == 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable none_;
  int count_ = 0;
};

}  // namespace

struct Listener::Impl {
  Impl(const RequestRouter& f, Executor& e, Options o)
      : router(f),
        executor(e),
        options(o),
        listener(web::uri("http://127.0.0.1:" + std::to_string(o.port))) {}

  /// A request in progress. Its last owner returns its share of the memory budget.
  struct Exchange {
    Exchange(Impl& i, const http_request& m) : impl(i), message(m) { impl.in_flight.enter(); }
    ~Exchange() {
      impl.body_bytes -= bytes;
      impl.in_flight.leave();
    }
    Exchange(const Exchange&) = delete;
    Exchange& operator=(const Exchange&) = delete;

    Impl& impl;
    http_request message;
    RequestRouter::Admitted admitted;
    std::int64_t bytes = 0;
  };
  using Shared = std::shared_ptr<Exchange>;

  void receive(const http_request& message);
  void run(const Shared& exchange);
  void refuse_body(const Shared& exchange, Response response);
  void reply(const Shared& exchange, const Response& response);

  const RequestRouter& router;
  Executor& executor;
  const Options options;
  http_listener listener;
  InFlight in_flight;
  std::atomic<std::int64_t> body_bytes{0};
  std::atomic<bool> draining{false};
};

void Listener::Impl::receive(const http_request& message) {
  const auto exchange = std::make_shared<Exchange>(*this, message);
  RequestRouter::Admission admission = router.admit(head_of(message));
  if (auto* response = std::get_if<Response>(&admission)) {
    refuse_body(exchange, std::move(*response));
    return;
  }
  exchange->admitted = std::get<RequestRouter::Admitted>(std::move(admission));
  const auto no_room = [&](const char* why) {
    refuse_body(exchange, router.refusal({ProblemKind::kBusy, why, {}, std::chrono::seconds(1)},
                                         exchange->admitted.request));
  };
  if (draining) return no_room("The server is shutting down. Please try again in a moment.");
  exchange->bytes = announced_bytes(message);
  if ((body_bytes += exchange->bytes) > options.body_budget) {
    return no_room("Too many uploads are in progress. Please try again in a moment.");
  }
  exchange->message.extract_vector()
      .then([this, exchange](const pplx::task<std::vector<unsigned char>>& body) {
        try {
          const auto& bytes = body.get();
          exchange->admitted.request.body.assign(bytes.begin(), bytes.end());
        } catch (const std::exception&) {
          // The peer disconnected during the body. The response cannot be delivered, but the
          // library requires one.
          reply(exchange,
                router.refusal({ProblemKind::kBadRequest, "The request body ended early.", {}, {}},
                               exchange->admitted.request));
          return;
        }
        if (!executor.submit([this, exchange] { run(exchange); })) {
          reply(exchange, router.refusal({ProblemKind::kBusy,
                                          "The server is busy. Please try again in a moment.",
                                          {},
                                          std::chrono::seconds(1)},
                                         exchange->admitted.request));
        }
      })
      .then([](const pplx::task<void>& done) {
        try {
          done.get();
        } catch (const std::exception& thrown) {
          log::error("failed to hand over a request", {{"reason", log::describe(thrown)}});
        }
      });
}

void Listener::Impl::run(const Shared& exchange) {
  try {
    const Response response = router.serve(exchange->admitted);
    exchange->admitted.request.body = {};
    reply(exchange, response);
  } catch (const std::exception& thrown) {
    log::error("reply failed", {{"reason", log::describe(thrown)}});
  }
}

void Listener::Impl::refuse_body(const Shared& exchange, Response response) {
  const bool chunked = exchange->message.headers().has("Transfer-Encoding");
  if (chunked || announced_bytes(exchange->message) > kSwallowBytes) {
    // Without an exception, a thread of the library would loop forever on a stream that accepts no
    // bytes.
    exchange->message.body().streambuf().close(
        std::ios_base::out, std::make_exception_ptr(std::runtime_error("request body refused")));
    response.with("Connection", "close");
  }
  reply(exchange, response);
}

void Listener::Impl::reply(const Shared& exchange, const Response& response) {
  http_response answer(static_cast<web::http::status_code>(response.status));
  // The library knows only some reason phrases, and not those of 428, 460 and 507.
  answer.set_reason_phrase(std::string(reason_phrase(response.status)));
  if (!response.body.empty()) {
    answer.set_body(response.body, response.content_type);
  } else if (!response.content_type.empty()) {
    answer.headers().set_content_type(response.content_type);
  }
  for (const auto& [name, value] : response.headers) answer.headers().add(name, value);
  if (draining) answer.headers()["Connection"] = "close";
  exchange->message.reply(answer).then([exchange](const pplx::task<void>& sent) {
    try {
      sent.get();
    } catch (const std::exception&) {
      // The peer has disconnected.
    }
  });
}

Result<std::unique_ptr<Listener>> Listener::open(const RequestRouter& router, Executor& executor,
                                                 Options options) {
  crossplat::threadpool::initialize_with_threads(static_cast<std::size_t>(options.library_threads));
  auto impl = std::make_unique<Impl>(router, executor, options);
  Impl* const raw = impl.get();
  const auto receive = [raw](const http_request& message) {
    try {
      raw->receive(message);
    } catch (const std::exception& thrown) {
      log::error("request refused", {{"reason", log::describe(thrown)}});
      message.reply(web::http::status_codes::InternalError).then([](const pplx::task<void>& sent) {
        try {
          sent.get();
        } catch (const std::exception&) {
        }
      });
    }
  };
  // Without handlers, the library answers these methods itself and echoes the request for TRACE.
  impl->listener.support(web::http::methods::OPTIONS, receive);
  impl->listener.support(web::http::methods::TRCE, receive);
  impl->listener.support(receive);
  try {
    impl->listener.open().get();
  } catch (const std::exception&) {
    return fail(ErrorCode::kUnavailable,
                "port " + std::to_string(options.port) + " on 127.0.0.1 is taken");
  }
  return std::unique_ptr<Listener>(new Listener(std::move(impl)));
}

Listener::Listener(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

void Listener::drain(std::chrono::milliseconds patience) {
  impl_->draining = true;
  if (!impl_->in_flight.wait_for_none(patience))
    log::warning("requests were still running at shutdown");
}

Listener::~Listener() {
  drain(std::chrono::milliseconds(0));
  const auto done = std::make_shared<std::promise<void>>();
  impl_->listener.close().then([done](const pplx::task<void>& closed) {
    try {
      closed.get();
    } catch (const std::exception& thrown) {
      log::warning("failed to close the listener cleanly", {{"reason", log::describe(thrown)}});
    }
    done->set_value();
  });
  // Leaks the state if the library still uses it.
  if (done->get_future().wait_for(kClosePatience) != std::future_status::ready)
    static_cast<void>(impl_.release());
}

}  // namespace diaphane::api
