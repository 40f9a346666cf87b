// SPDX-License-Identifier: MIT
#include "TraceReplay.h"

#include <algorithm>
#include <cstdlib>

namespace openntc_tests {

using namespace openntc;

namespace {

/// Rows joined by `/`: `.` or `-` is 255, a hexadecimal digit itself, `(n)` any number.
std::vector<std::uint8_t> ReadMap(const std::string& text) {
    std::vector<std::uint8_t> map;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '/')
            continue;
        if (c == '(') {
            map.push_back(static_cast<std::uint8_t>(std::strtol(text.c_str() + i + 1, nullptr, 10)));
            i = text.find(')', i);
        } else {
            map.push_back(c == '.' || c == '-'
                              ? std::uint8_t{255}
                              : static_cast<std::uint8_t>(c <= '9' ? c - '0' : c - 'a' + 10));
        }
    }
    return map;
}

std::string WriteMap(std::span<const std::uint8_t> map) {
    std::string text;
    for (const std::uint8_t value : map)
        text += value == 255 ? std::string("-") : std::to_string(value);
    return text;
}

/// The member of `right`, else of `out`, else null.
const rapidjson::Value* FindRight(const rapidjson::Value& step, const char* member) {
    for (const char* from : {"right", "out"}) {
        if (step.HasMember(from) && step[from].IsObject() && step[from].HasMember(member))
            return &step[from][member];
    }
    return nullptr;
}

int GetInt(const rapidjson::Value& step, const char* member, int otherwise) {
    return step.HasMember(member) ? step[member].GetInt() : otherwise;
}

} // namespace

void TraceReplay::Report(const std::string& text) {
    findings_.push_back("step " + std::to_string(step_) + ": " + text);
}

ManagedTextureId TraceReplay::Find(const rapidjson::Value& step, const char* member) const {
    const auto found = textures_.find(step[member].GetInt());
    return found != textures_.end() ? found->second : ManagedTextureId{1000000, 1};
}

int TraceReplay::GetNumber(ManagedTextureId id) const {
    for (const auto& entry : textures_) {
        if (entry.second == id)
            return entry.first;
    }
    return -1;
}

Status TraceReplay::Add(const rapidjson::Value& step) {
    TileLayoutDesc desc;
    desc.width = step["size"][0].GetInt();
    desc.height = step["size"][1].GetInt();
    desc.tileWidth = step["tile"][0].GetInt();
    desc.tileHeight = step["tile"][1].GetInt();
    desc.levelCount = static_cast<int>(step["levels"].Size());
    desc.mips = desc.levelCount + step["packedMips"].GetInt();
    desc.tailTiles = step["packedTiles"].GetInt();
    const auto layout = TileLayout::Create(desc);
    if (!layout)
        return layout.error().GetStatus();
    for (rapidjson::SizeType i = 0; i < step["levels"].Size(); ++i) {
        if (layout->GetLevels()[i].tilesX != step["levels"][i][0].GetInt() ||
            layout->GetLevels()[i].tilesY != step["levels"][i][1].GetInt())
            Report("tiles of level " + std::to_string(i));
    }
    const auto id = manager_->AddTexture(*layout);
    if (!id)
        return id.error().GetStatus();
    textures_[static_cast<int>(id->index)] = *id;
    if (step.HasMember("out")) {
        const rapidjson::Value& out = step["out"];
        CompareNumber("id", id->index, out["id"]);
        CompareNumber("region width", static_cast<std::uint64_t>(layout->GetRegionWidth()), out["region"][0]);
        CompareNumber("region height", static_cast<std::uint64_t>(layout->GetRegionHeight()),
                      out["region"][1]);
        CompareNumber("mips", static_cast<std::uint64_t>(layout->GetMips()), out["mips"]);
        CompareNumber("map width", static_cast<std::uint64_t>(layout->GetResidencyWidth()), out["minMip"][0]);
        CompareNumber("map height", static_cast<std::uint64_t>(layout->GetResidencyHeight()),
                      out["minMip"][1]);
    }
    return Status::Ok;
}

Status TraceReplay::Update(const rapidjson::Value& step) {
    std::vector<std::uint8_t> feedback;
    if (step["feedback"].IsString())
        feedback = ReadMap(step["feedback"].GetString());
    TileUpdateOptions options;
    options.time = step["t"].GetDouble();
    options.timeout = step["timeout"].GetDouble();
    options.bias = GetInt(step, "bias", 0);
    options.streamedMips = GetInt(step, "streamedMips", 0);
    const auto updated = manager_->UpdateWithSamplerFeedback(Find(step), feedback, options);
    return updated ? Status::Ok : updated.error().GetStatus();
}

Status TraceReplay::Match(const rapidjson::Value& step) {
    const auto matched = manager_->MatchPrimaryTexture(Find(step, "primary"), Find(step, "follower"),
                                                       step["t"].GetDouble(), step["timeout"].GetDouble());
    return matched ? Status::Ok : matched.error().GetStatus();
}

void TraceReplay::Collect() {
    unmaps_.clear();
    maps_.clear();
    const TileOrders orders = manager_->FetchOrders();
    for (const TileUnmapOrder& order : orders.unmaps) {
        if (!unmaps_[GetNumber(order.texture)].insert(order.tile).second)
            Report("tile " + std::to_string(order.tile) + " is unmapped twice");
    }
    for (const TileMapOrder& order : orders.maps) {
        if (!maps_[GetNumber(order.texture)].insert(order.tile).second)
            Report("tile " + std::to_string(order.tile) + " is mapped twice");
        waiting_.push_back(order);
    }
    moving_.insert(moving_.end(), orders.moves.begin(), orders.moves.end());
}

Status TraceReplay::Confirm(const rapidjson::Value& step) {
    if (step.HasMember("tiles")) {
        std::vector<std::uint32_t> tiles;
        for (const rapidjson::Value& tile : step["tiles"].GetArray())
            tiles.push_back(tile.GetUint());
        const auto confirmed = manager_->UpdateTilesMapping(Find(step), tiles);
        return confirmed ? Status::Ok : confirmed.error().GetStatus();
    }
    (void)manager_->ConfirmOrders(std::span<const TileMapOrder>(waiting_));
    (void)manager_->ConfirmOrders(std::span<const TileMoveOrder>(moving_));
    waiting_.clear();
    moving_.clear();
    return Status::Ok;
}

Status TraceReplay::RunStep(const rapidjson::Value& step) {
    const std::string op = step["op"].GetString();
    const auto getStatus = [](const auto& result) {
        return result ? Status::Ok : result.error().GetStatus();
    };
    if (op == "manager") {
        TileManagerDesc desc;
        desc.tilesPerHeap = step["heapTiles"].GetUint();
        auto manager = TileManager::Create(desc);
        if (!manager)
            return manager.error().GetStatus();
        manager_.emplace(std::move(*manager));
        return Status::Ok;
    }
    if (op == "config") {
        standbyTarget_ = step["standby"].GetUint();
        manager_->SetStandbyTarget(standbyTarget_);
        return Status::Ok;
    }
    if (op == "add")
        return Add(step);
    if (op == "remove")
        return getStatus(manager_->RemoveTexture(Find(step)));
    if (op == "update")
        return Update(step);
    if (op == "match")
        return Match(step);
    if (op == "addHeap")
        return getStatus(manager_->AddHeap(step["id"].GetUint()));
    if (op == "removeHeap")
        return getStatus(manager_->RemoveHeap(step["id"].GetUint()));
    if (op == "trim")
        return getStatus(manager_->TrimStandbyTiles());
    if (op == "allocate")
        return getStatus(manager_->AllocateRequestedTiles());
    if (op == "defrag") {
        hasMoved_ = true;
        return getStatus(manager_->DefragmentTiles(step["n"].GetUint()));
    }
    if (op == "confirm")
        return Confirm(step);
    if (op == "collect")
        Collect();
    else if (op != "desired" && op != "check")
        Report("unknown step " + op);
    return Status::Ok;
}

void TraceReplay::Run(const rapidjson::Value& trace) {
    for (const rapidjson::Value& member : trace["policyFields"].GetArray())
        policy_.insert(member.GetString());
    for (const rapidjson::Value& step : trace["steps"].GetArray()) {
        if (std::string(step["op"].GetString()) == "removeHeap") {
            const auto use = manager_->GetHeapUse(step["id"].GetUint());
            isRemovable_ = use && *use == 0;
        }
        const Status status = RunStep(step);
        if (!manager_) {
            Report("no manager");
            return;
        }
        if (const auto checked = manager_->CheckInvariants(); !checked)
            Report(checked.error().GetText());
        Compare(step, status);
        if (std::string(step["op"].GetString()) == "remove")
            textures_.erase(step["tex"].GetInt());
        ++step_;
    }
}

void TraceReplay::CompareNumber(const char* name, std::uint64_t has, const rapidjson::Value& right) {
    ++comparisons_;
    if (right.GetUint64() != has)
        Report(std::string(name) + ": " + std::to_string(has) +
               ", right: " + std::to_string(right.GetUint64()));
}

void TraceReplay::Compare(const rapidjson::Value& step, Status status) {
    const std::string op = step["op"].GetString();
    if (op == "removeHeap") {
        ++comparisons_;
        // Which heaps are in use is free where their use is.
        if ((status == Status::Ok) != (IsPolicy("heapUsed") ? isRemovable_ : step["right"].GetBool()))
            Report("removal of a heap: " + std::string(StatusToString(status)));
        return;
    }
    if (status != Status::Ok)
        Report(op + ": " + StatusToString(status));
    if (op == "desired")
        CompareNumber("desired heaps", manager_->GetNumDesiredHeaps(),
                      step.HasMember("right") ? step["right"] : step["out"]);
    else if (op == "collect" && !hasMoved_)
        CompareCollected(step);
    else if (op == "check")
        CompareState(step);
}

void TraceReplay::CompareCollected(const rapidjson::Value& step) {
    for (const auto& [name, has] : {std::pair("unmap", &unmaps_), std::pair("map", &maps_)}) {
        if (IsPolicy(name))
            continue;
        Tiles right;
        for (const auto& member : FindRight(step, name)->GetObject()) {
            for (const rapidjson::Value& tile : member.value.GetArray())
                right[std::atoi(member.name.GetString())].insert(tile.GetUint());
        }
        ++comparisons_;
        if (right != *has)
            Report(std::string(name) + " orders differ");
    }
}

void TraceReplay::CompareState(const rapidjson::Value& step) {
    const TileManagerStatistics statistics = manager_->GetStatistics();
    const std::pair<const char*, std::uint64_t> numbers[] = {
        {"total", statistics.tiles},
        {"allocated", statistics.usedSlots},
        {"standby", statistics.standbyTiles},
        {"free", statistics.freeSlots},
        {"desiredHeaps", manager_->GetNumDesiredHeaps()}};
    for (const auto& [name, has] : numbers) {
        if (const rapidjson::Value* right = FindRight(step, name); right != nullptr && !IsPolicy(name))
            CompareNumber(name, has, *right);
    }
    Array<std::uint32_t> empty;
    if (!manager_->GetEmptyHeaps(empty))
        Report("no list of empty heaps");
    if (!IsPolicy("emptyHeaps")) {
        std::set<std::uint32_t> right;
        for (const rapidjson::Value& heap : FindRight(step, "emptyHeaps")->GetArray())
            right.insert(heap.GetUint());
        ++comparisons_;
        if (right != std::set<std::uint32_t>(empty.begin(), empty.end()))
            Report("empty heaps differ");
    } else if (hasMoved_) { // at least as many as freeing and requesting gives
        ++comparisons_;
        if (empty.size() < FindRight(step, "emptyHeaps")->Size())
            Report("fewer empty heaps: " + std::to_string(empty.size()));
    }
    if (!IsPolicy("heapUsed")) {
        for (const auto& member : FindRight(step, "heapUsed")->GetObject()) {
            const auto use =
                manager_->GetHeapUse(static_cast<std::uint32_t>(std::atoi(member.name.GetString())));
            if (use)
                CompareNumber("use of a heap", *use, member.value);
            else
                Report("heap is not there");
        }
    }
    CompareMaps(*FindRight(step, "minMip"));
}

void TraceReplay::CompareMaps(const rapidjson::Value& maps) {
    if (IsPolicy("minMip") && !hasMoved_)
        return;
    for (const auto& member : maps.GetObject()) {
        const auto map = manager_->GetResidencyMap(textures_.at(std::atoi(member.name.GetString())));
        if (!map) {
            Report("no residency map");
            continue;
        }
        const std::vector<std::uint8_t> right = ReadMap(member.value.GetString());
        ++comparisons_;
        bool isGood = right.size() == map->size();
        for (std::size_t i = 0; isGood && i < right.size(); ++i)
            isGood = hasMoved_ ? (*map)[i] <= right[i] : (*map)[i] == right[i];
        if (!isGood)
            Report("residency map of " + std::string(member.name.GetString()) + ": " + WriteMap(*map) +
                   ", right: " + WriteMap(right));
    }
}

} // namespace openntc_tests
