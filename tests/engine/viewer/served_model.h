#pragma once

// A server with a model that remembers what the server asked of it.

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/viewer/view_server.h"

namespace palpate::test {

class RememberingModel final : public ViewModel {
 public:
  bool newest(ViewState& state, std::vector<BodyPose>& bodies) override {
    const std::lock_guard lock(mutex_);
    ++state_.record.tick;  // every state is a new one
    state = state_;
    bodies.assign(body_count_, {});
    return true;
  }
  std::uint64_t take_ticks(std::vector<TickSummary>& rows) override {
    rows.emplace_back();
    return 0;
  }
  double rate_Hz() const override { return 1000.0; }
  std::string hello(PageRole) override { return R"({"type":"hello"})"; }
  std::string status(PageRole, std::size_t clients) override {
    return R"({"type":"status","clients":)" + std::to_string(clients) + "}";
  }
  std::optional<Event> take_event() override { return std::nullopt; }
  void point(const PointerMessage& message) override {
    const std::lock_guard lock(mutex_);
    pointers_.push_back(message);
    state_.pointer = message.sequence;
  }
  void let_go() override {
    const std::lock_guard lock(mutex_);
    ++let_goes_;
    state_.pointer = 0;
  }
  std::optional<std::string> carry_out(const PageRequest& request) override {
    const std::lock_guard lock(mutex_);
    if (request.kind == PageRequest::Kind::kSet && request.name == "wrong")
      return "wrong: is wrong";
    requests_.push_back(request);
    return std::nullopt;
  }
  std::shared_ptr<const std::string> scene_bytes(bool full) override {
    return std::make_shared<const std::string>(full ? "the full scene" : "the scene");
  }

  // Each state has so many moving bodies.
  void set_bodies(std::size_t count) {
    const std::lock_guard lock(mutex_);
    body_count_ = count;
  }
  std::vector<PageRequest> requests() {
    const std::lock_guard lock(mutex_);
    return requests_;
  }
  std::vector<PointerMessage> pointers() {
    const std::lock_guard lock(mutex_);
    return pointers_;
  }
  int let_goes() {
    const std::lock_guard lock(mutex_);
    return let_goes_;
  }

 private:
  std::mutex mutex_;
  ViewState state_;
  std::vector<PageRequest> requests_;
  std::vector<PointerMessage> pointers_;
  int let_goes_ = 0;
  std::size_t body_count_ = 0;
};

// A running server with a page of four short files.
struct ServedModel {
  explicit ServedModel(ServerSettings settings = {}) {
    const PageFiles page{"<!doctype html>the page", "the script", "the style", "the icon"};
    auto listening = ViewServer::listen(settings, page, model);
    EXPECT_TRUE(listening.ok()) << listening.error().to_string();
    server = std::move(*listening);
    server->start();
    port = server->port();
    host = "127.0.0.1:" + std::to_string(port);
    token = server->token().text();
  }

  std::string token_message() const { return R"({"type":"token","token":")" + token + "\"}"; }

  RememberingModel model;
  std::unique_ptr<ViewServer> server;
  std::uint16_t port = 0;
  std::string host;
  std::string token;
};

}  // namespace palpate::test
