#include "api/accounts/password.h"

#include <argon2.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "api/accounts/common_passwords.h"
#include "common/ids.h"

namespace diaphane::api {
namespace {

constexpr std::uint32_t kLanes = 1;
constexpr std::size_t kHashBytes = 32;

/// Counts characters of valid UTF-8 instead of bytes.
std::size_t characters_in(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  }));
}

std::string encode(std::string_view password, const PasswordCost& cost) {
  const std::string salt = random_hex(16);
  std::array<char, 256> encoded{};
  const int error =
      argon2id_hash_encoded(cost.passes, cost.memory_kib, kLanes, password.data(), password.size(),
                            salt.data(), salt.size(), kHashBytes, encoded.data(), encoded.size());
  if (error != ARGON2_OK) throw std::runtime_error(argon2_error_message(error));
  return encoded.data();
}

}  // namespace

std::optional<std::string> fault_of_password(std::string_view password, std::string_view email) {
  const std::size_t length = characters_in(password);
  if (length < 12) return "Use at least 12 characters.";
  if (length > 200) return "Use at most 200 characters.";
  if (email_key(password) == email_key(email))
    return "Your password must be different from your email address.";
  return weakness_of(password, email_key(email.substr(0, email.find('@'))));
}

bool is_email(std::string_view text) {
  if (text.size() < 3 || text.size() > 254) return false;
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
    return c > 0x20 && c < 0x7f && c != '<' && c != '>' && c != '"' && c != ',' && c != ';' &&
           c != ':' && c != '\\' && c != '(' && c != ')' && c != '[' && c != ']';
  });
  const std::size_t at = text.find('@');
  if (!plain || at == std::string_view::npos || at == 0 || at > 64) return false;
  const std::string_view domain = text.substr(at + 1);
  return !domain.empty() && domain.find('@') == std::string_view::npos && domain.front() != '.' &&
         domain.back() != '.' && domain.find("..") == std::string_view::npos;
}

std::string email_key(std::string_view email) {
  std::string key(email);
  std::transform(key.begin(), key.end(), key.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return key;
}

class PasswordHasher::Turn {
 public:
  explicit Turn(PasswordHasher& hasher) : hasher_(hasher), mine_(hasher.enter()) {}
  ~Turn() {
    if (mine_) hasher_.leave();
  }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
  explicit operator bool() const { return mine_; }
  static tl::unexpected<Error> none() {
    return fail(ErrorCode::kUnavailable,
                "Too many people are signing in right now. Please try again in a moment.");
  }

 private:
  PasswordHasher& hasher_;
  bool mine_;
};

PasswordHasher::PasswordHasher(int slots, std::chrono::milliseconds patience, PasswordCost cost)
    : slots_(slots), patience_(patience), cost_(cost), nothing_(encode(random_hex(32), cost)) {}

bool PasswordHasher::enter() {
  std::unique_lock lock(mutex_);
  if (running_ == slots_) {
    if (waiting_ == slots_ * 2) return false;
    ++waiting_;
    const bool acquired = free_.wait_for(lock, patience_, [this] { return running_ < slots_; });
    --waiting_;
    if (!acquired) return false;
  }
  ++running_;
  return true;
}

void PasswordHasher::leave() {
  const std::lock_guard lock(mutex_);
  --running_;
  free_.notify_one();
}

Result<std::string> PasswordHasher::hash(std::string_view password) {
  const Turn turn(*this);
  if (!turn) return Turn::none();
  return encode(password, cost_);
}

Result<bool> PasswordHasher::verify(std::string_view password, const std::string& encoded) {
  const Turn turn(*this);
  if (!turn) return Turn::none();
  return argon2id_verify(encoded.c_str(), password.data(), password.size()) == ARGON2_OK;
}

Result<bool> PasswordHasher::verify_dummy(std::string_view password) {
  auto done = verify(password, nothing_);
  if (!done) return done;
  return false;
}

}  // namespace diaphane::api
