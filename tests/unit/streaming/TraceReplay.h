// SPDX-License-Identifier: MIT
// Replays recorded scenarios of tile managers: the steps run on ours, its answers are compared with what the
// scenario says is right.
#pragma once

#include "openntc/streaming/TileManager.h"

#include <rapidjson/document.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace openntc_tests {

/// One scenario's run. Failed comparisons are reported as text, with the number of the step.
class TraceReplay {
public:
    /// Compares each step with its `right`, else `out`. Members named as policy are judged by the manager's
    /// invariants alone, which are checked after every step of every scenario.
    void Run(const rapidjson::Value& trace);

    /// Runs a step and does not compare; for scenarios that are told in words. Ok, or what the step failed
    /// with.
    openntc::Status RunStep(const rapidjson::Value& step);

    const std::vector<std::string>& GetFindings() const { return findings_; }
    openntc::TileManager& GetManager() { return *manager_; }
    openntc::ManagedTextureId GetTexture(int number) const { return textures_.at(number); }
    std::size_t GetComparisons() const { return comparisons_; }
    bool HasManager() const { return manager_.has_value(); }

private:
    using Tiles = std::map<int, std::set<std::uint32_t>>; // by the scenario's number of the texture

    openntc::Status Add(const rapidjson::Value& step);
    openntc::Status Update(const rapidjson::Value& step);
    openntc::Status Match(const rapidjson::Value& step);
    openntc::Status Confirm(const rapidjson::Value& step);
    void Collect();
    void Compare(const rapidjson::Value& step, openntc::Status status);
    void CompareAdded(const rapidjson::Value& step);
    void CompareCollected(const rapidjson::Value& step);
    void CompareState(const rapidjson::Value& step);
    void CompareMaps(const rapidjson::Value& maps);
    void CompareNumber(const char* name, std::uint64_t has, const rapidjson::Value& right);
    int GetNumber(openntc::ManagedTextureId id) const;
    openntc::ManagedTextureId Find(const rapidjson::Value& step, const char* member = "tex") const;
    bool IsPolicy(const std::string& member) const { return policy_.count(member) != 0; }
    void Report(const std::string& text);

    std::optional<openntc::TileManager> manager_;
    std::map<int, openntc::ManagedTextureId> textures_;
    std::set<std::string> policy_;
    Tiles unmaps_;
    Tiles maps_;
    std::vector<openntc::TileMapOrder> waiting_;
    std::vector<openntc::TileMoveOrder> moving_;
    std::uint32_t standbyTarget_ = 0;
    std::size_t step_ = 0;
    std::size_t comparisons_ = 0;
    bool isRemovable_ = false;
    bool hasMoved_ = false; // moves instead of freeing and requesting: orders differ from here on
    std::vector<std::string> findings_;
};

} // namespace openntc_tests
