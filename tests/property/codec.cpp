// Encoder and decoder on random manifolds with random values.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include "model.hpp"

namespace {

// Every mesh that a full decoding goes through, by its number of vertices.
std::map<uint32_t, Picture> all_pictures(const Stream &s)
{
    Decoding d(s);
    std::map<uint32_t, Picture> pictures;
    cq_bytes in = {s.c.bytes, s.c.size};
    cq_result result;
    do {
        result = cq_decode(d.d.decoder, &in, 1);
        if (d.num_vertices() > 0) pictures.insert_or_assign(d.num_vertices(), Picture(*d.d.decoder));
    } while (result == CQ_MORE);
    RC_ASSERT(result == CQ_DONE);
    return pictures;
}

void decoding_gives_back_the_faces_and_values_through_the_map()
{
    Model model(*any_recipe(4.0));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    std::set<uint32_t> images(s.c.map, s.c.map + model.mesh.num_vertices);
    RC_ASSERT(images.size() == model.mesh.num_vertices);
    RC_ASSERT(*images.rbegin() == model.mesh.num_vertices - 1);
    Decoding d(s);
    RC_ASSERT(decoding_run(&d.d, s.c.bytes, s.c.size, s.c.size, CQ_NO_LIMIT) == CQ_DONE);
    RC_ASSERT(d.d.used == s.c.size);
    RC_ASSERT(is_presentable(*d.d.decoder));
    RC_ASSERT(same_mesh(model, s.c, *d.d.decoder));
    RC_TAG(s.c.report->num_levels == 0 ? "no level" : s.c.report->num_levels < 5 ? "1 to 4 levels" : "more levels");
}

void both_goals_give_back_the_same_mesh()
{
    Model model(*any_recipe(4.0));
    for (cq_goal goal : {CQ_BALANCED, CQ_LEAST_CONNECTIVITY}) {
        model.input.goal = goal;
        Stream s(model);
        RC_ASSERT(s.c.result == CQ_OK);
        Decoding d(s);
        RC_ASSERT(decoding_run(&d.d, s.c.bytes, s.c.size, s.c.size, CQ_NO_LIMIT) == CQ_DONE);
        RC_ASSERT(same_mesh(model, s.c, *d.d.decoder));
    }
}

void large_meshes_come_back_too()
{
    Model model(*any_recipe(25.0));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    Decoding d(s);
    RC_ASSERT(decoding_run(&d.d, s.c.bytes, s.c.size, 1000, 1000) == CQ_DONE);
    RC_ASSERT(same_mesh(model, s.c, *d.d.decoder));
    RC_ASSERT(cq_mesh_check(&d.mesh(), nullptr) == CQ_OK);
    RC_TAG(model.mesh.num_vertices > 1000 ? "more than 1000 vertices" : "up to 1000");
}

void every_step_of_the_decoder_leaves_a_mesh_of_the_same_topology()
{
    Model model(*any_recipe(0.6));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    Surface full = examine(model.mesh.faces);
    Decoding d(s);
    cq_bytes in = {s.c.bytes, s.c.size};
    cq_result result;
    uint32_t before = 0, level = 0;
    do {
        result = cq_decode(d.d.decoder, &in, 1);
        RC_ASSERT(result == CQ_MORE || result == CQ_DONE);
        const uint32_t now = d.num_vertices();
        const bool base_is_complete = result == CQ_DONE || d.d.decoder->level > 0;
        RC_ASSERT(level == 0 || now == before || now == before + 1);
        if (now == before && level == d.d.decoder->level && result == CQ_MORE) continue;
        RC_ASSERT(is_presentable(*d.d.decoder));
        if (base_is_complete) {
            Surface surface = examine(faces_of(d.mesh()));
            RC_ASSERT(surface.vertices == now);
            RC_ASSERT(surface.same_topology(full));
        }
        before = now;
        level = d.d.decoder->level;
    } while (result == CQ_MORE);
}

// Cut anywhere in the base, a stream gives some components, and those of any shorter prefix are the first of them.
void every_prefix_of_the_base_is_a_mesh_that_only_grew()
{
    Model model(*any_recipe(0.8));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    std::vector<Face> before;
    uint32_t components = 0;
    for (size_t size = 0; size < s.c.size; ++size) {
        Decoding d(s);
        RC_ASSERT(decoding_run(&d.d, s.c.bytes, size, s.c.size, CQ_NO_LIMIT) == CQ_TRUNCATED);
        if (d.d.decoder->level > 0) break;
        RC_ASSERT(is_presentable(*d.d.decoder));
        const std::vector<Face> now = faces_of(d.mesh());
        RC_ASSERT(now.size() >= before.size() && std::equal(before.begin(), before.end(), now.begin()));
        RC_ASSERT(d.d.decoder->num_components >= components);
        components = d.d.decoder->num_components;
        before = now;
    }
    RC_ASSERT(components <= s.c.report->num_components);
}

using Values = std::vector<std::vector<int64_t>>;   // by channel

Values values_of(const cq_decoder &d)
{
    Values values(d.shape.num_channels);
    for (uint32_t k = 0; k < d.shape.num_channels; ++k)
        values[k].assign(d.channel[k], d.channel[k] + num_shown(&d, k));
    return values;
}

// Is everything that was there as it was?
bool only_grew(const Values &before, const Values &after)
{
    for (size_t k = 0; k < before.size(); ++k)
        if (before[k].size() > after[k].size() || !std::equal(before[k].begin(), before[k].end(), after[k].begin()))
            return false;
    return true;
}

void values_never_change_once_they_have_arrived()
{
    Model model(*any_recipe(1.0));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    Decoding d(s);
    cq_bytes in = {s.c.bytes, s.c.size};
    cq_result result;
    Values before(model.input.shape.num_channels);
    do {
        result = cq_decode(d.d.decoder, &in, 1);
        Values after = values_of(*d.d.decoder);
        RC_ASSERT(only_grew(before, after));
        before = after;
    } while (result == CQ_MORE);
    RC_ASSERT(result == CQ_DONE);
}

void every_prefix_is_a_mesh_on_the_way_to_the_full_one()
{
    Model model(*any_recipe(0.8));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    auto pictures = all_pictures(s);
    uint32_t before = 0;
    for (size_t size = 0; size < s.c.size; ++size) {
        Decoding d(s);
        RC_ASSERT(decoding_run(&d.d, s.c.bytes, size, s.c.size, CQ_NO_LIMIT) == CQ_TRUNCATED);
        RC_ASSERT(d.d.used == size);
        uint32_t now = d.num_vertices();
        RC_ASSERT(now >= before && now <= model.mesh.num_vertices);
        if (now > 0) {
            RC_ASSERT(cq_mesh_check(&d.mesh(), nullptr) == CQ_OK);
            RC_ASSERT(pictures.count(now) == 1);
            RC_ASSERT(pictures.at(now) == Picture(*d.d.decoder));
        }
        before = now;
    }
}

void any_pieces_and_any_budgets_give_the_same_mesh()
{
    Model model(*any_recipe(2.0));
    auto numbers = *any_numbers(0.5);
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    Decoding whole(s), parts(s);
    RC_ASSERT(decoding_run(&whole.d, s.c.bytes, s.c.size, s.c.size, CQ_NO_LIMIT) == CQ_DONE);
    numbers.push_back(1);
    size_t at = 0, k = 0;
    cq_result result = CQ_NEED_INPUT;
    while (result != CQ_DONE) {
        Random random{numbers[k % numbers.size()] + k};
        k++;
        size_t piece = random.below(4) == 0 ? random.below(2) : random.below(1 + s.c.size / 4);
        piece = std::min(piece, s.c.size - at);
        result = decoding_feed(&parts.d, s.c.bytes + at, piece, 1 + random.below(20));
        at += piece;
        RC_ASSERT(result == (at == s.c.size ? CQ_DONE : CQ_NEED_INPUT));
        RC_ASSERT(parts.d.used == at);
    }
    RC_ASSERT(Picture(*whole.d.decoder) == Picture(*parts.d.decoder));
}

// A call with a budget that stops in the middle of a piece leaves the rest of it to be given again.
void a_decoder_can_be_stopped_anywhere_and_go_on_later()
{
    Model model(*any_recipe(1.5));
    auto numbers = *any_numbers(0.5);
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    Decoding whole(s), parts(s);
    RC_ASSERT(decoding_run(&whole.d, s.c.bytes, s.c.size, s.c.size, CQ_NO_LIMIT) == CQ_DONE);
    numbers.push_back(1);
    size_t at = 0, k = 0;
    cq_result result = CQ_OK;
    while (result != CQ_DONE) {
        RC_ASSERT(k < 100000u);
        Random random{numbers[k % numbers.size()] + k};
        k++;
        size_t size = std::min<size_t>(random.below(40), s.c.size - at);
        Exact piece(s.c.bytes + at, size);
        cq_bytes in = {piece.data(), size};
        result = cq_decode(parts.d.decoder, &in, random.below(6));
        RC_ASSERT(in.data == piece.data() + (size - in.size));
        at += size - in.size;
        RC_ASSERT(result > CQ_OK && result != CQ_TRUNCATED);
    }
    RC_ASSERT(at == s.c.size);
    RC_ASSERT(Picture(*whole.d.decoder) == Picture(*parts.d.decoder));
}

// What a decoder may say to a damaged stream; it must not take the damage for the mesh.
void check_damaged(const Model &model, const Stream &s, const std::vector<uint8_t> &bytes)
{
    Decoding d(bytes.data(), bytes.size());
    size_t chunk = 1 + bytes.size() / 3;
    cq_result result = decoding_run(&d.d, bytes.data(), bytes.size(), chunk, CQ_NO_LIMIT);
    RC_ASSERT(result < 0 || result == CQ_TRUNCATED || result == CQ_DONE);
    RC_ASSERT(is_presentable(*d.d.decoder));
    if (result == CQ_DONE) RC_ASSERT(same_mesh(model, s.c, *d.d.decoder));
    RC_ASSERT(cq_decode(d.d.decoder, nullptr, 1) == result);
}

std::vector<uint8_t> bytes_of(const Stream &s) { return std::vector<uint8_t>(s.c.bytes, s.c.bytes + s.c.size); }

void flipped_bits_give_an_error_or_a_coarser_mesh()
{
    Model model(*any_recipe(1.0));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    Random random{*rc::gen::arbitrary<uint32_t>()};
    for (uint32_t round = 0; round < 15; ++round) {
        std::vector<uint8_t> bytes = bytes_of(s);
        for (uint32_t flips = 1 + random.below(1 + round); flips > 0; --flips)
            bytes[random.below(bytes.size())] ^= static_cast<uint8_t>(1 << random.below(8));
        check_damaged(model, s, bytes);
    }
}

void replaced_inserted_and_missing_bytes_give_an_error_or_a_coarser_mesh()
{
    Model model(*any_recipe(1.0));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    Random random{*rc::gen::arbitrary<uint32_t>()};
    for (int round = 0; round < 15; ++round) {
        std::vector<uint8_t> bytes = bytes_of(s);
        auto at = static_cast<ptrdiff_t>(random.below(bytes.size()));
        ptrdiff_t count = 1 + random.below(20), rest = static_cast<ptrdiff_t>(bytes.size()) - at;
        switch (random.below(3)) {
        case 0: bytes.erase(bytes.begin() + at, bytes.begin() + at + std::min(count, rest)); break;
        case 1: bytes.insert(bytes.begin() + at, static_cast<size_t>(count), static_cast<uint8_t>(random())); break;
        default:
            for (ptrdiff_t k = at; k < at + std::min(count, rest); ++k)
                bytes[static_cast<size_t>(k)] = static_cast<uint8_t>(random());
            break;
        }
        check_damaged(model, s, bytes);
    }
}

uint32_t crc32(const uint8_t *data, size_t size)
{
    uint32_t crc = 0xffffffffu;
    for (size_t k = 0; k < size; ++k) {
        crc ^= data[k];
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

// Both check values are made right again, so that the damage gets as far as it can: any mesh is then fine.
void damage_with_right_check_values_gives_an_error_or_a_valid_mesh()
{
    Model model(*any_recipe(1.0));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    size_t header = s.header_size(), payload = s.c.size - header;
    Random random{*rc::gen::arbitrary<uint32_t>()};
    int complete = 0;
    for (int round = 0; round < 20; ++round) {
        std::vector<uint8_t> bytes = bytes_of(s);
        bool in_header = random.below(2) == 0;
        for (uint32_t flips = 1 + random.below(4); flips > 0; --flips) {
            size_t at = in_header ? 3 + random.below(header - 3 - 6) : header + random.below(payload);
            bytes[at] ^= static_cast<uint8_t>(random.below(2) == 0 ? 1 << random.below(8) : random.below(256));
        }
        uint32_t crc = crc32(bytes.data() + header, payload);
        for (size_t k = 0; k < 4; ++k) bytes[header - 6 + k] = static_cast<uint8_t>(crc >> (8 * k));
        crc = crc32(bytes.data(), header - 2);
        for (size_t k = 0; k < 2; ++k) bytes[header - 2 + k] = static_cast<uint8_t>(crc >> (8 * k));
        cq_shape shape;
        cq_result peeked = cq_peek(bytes.data(), bytes.size(), &shape, nullptr, nullptr);
        if (peeked != CQ_OK) continue;
        if (cq_decoder_bytes(&shape) > 1u << 22) continue;   // a count of millions
        Decoding d(bytes.data(), bytes.size());
        decoding_report(&d.d);
        Exact all(bytes.data(), bytes.size());
        cq_bytes in = {all.data(), bytes.size()};
        size_t steps = 0, limit = 1000 + 100 * (shape.num_vertices + bytes.size());
        cq_result result;
        do result = cq_decode(d.d.decoder, &in, 1);
        while (result == CQ_MORE && ++steps < limit);
        RC_ASSERT(steps < limit);   // work is bounded for hostile streams too
        if (result == CQ_NEED_INPUT) result = decoding_end(&d.d, CQ_NO_LIMIT);
        RC_ASSERT((result < 0 || result == CQ_TRUNCATED || result == CQ_DONE));
        RC_ASSERT(is_presentable(*d.d.decoder));
        if (result == CQ_DONE) RC_ASSERT(d.num_vertices() == d.d.decoder->shape.num_vertices);
        if (result == CQ_DONE) RC_ASSERT(d.mesh().num_faces == d.d.decoder->shape.num_faces);
        complete += result == CQ_DONE;
    }
    RC_TAG(complete > 0 ? "some complete" : "none complete");
}

void noise_behind_a_good_header_gives_an_error_or_a_valid_mesh()
{
    Model model(*any_recipe(1.0));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    size_t header = s.header_size();
    Random random{*rc::gen::arbitrary<uint32_t>()};
    for (int round = 0; round < 10; ++round) {
        std::vector<uint8_t> bytes = bytes_of(s);
        uint32_t zeros = random.below(8);
        for (size_t k = header; k < bytes.size(); ++k)
            bytes[k] = random.below(8) < zeros ? 0 : static_cast<uint8_t>(random());
        check_damaged(model, s, bytes);
    }
}

void the_parts_of_the_report_add_up_and_both_sides_agree()
{
    Model model(*any_recipe(2.0));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    Decoding d(s);
    decoding_report(&d.d);
    RC_ASSERT(decoding_run(&d.d, s.c.bytes, s.c.size, 31, 5) == CQ_DONE);
    const cq_report &a = *s.c.report, &b = *d.d.report;
    Surface full = examine(model.mesh.faces);
    uint64_t all = a.header + a.base + a.flags + a.indices + a.positions + a.channels + a.aside;
    RC_ASSERT(all == uint64_t(s.c.size) * 8 * 65536);
    RC_ASSERT(a.bytes == s.c.size && b.bytes == s.c.size);
    RC_ASSERT(a.header == b.header && a.base == b.base && a.flags == b.flags && a.indices == b.indices);
    RC_ASSERT(a.positions == b.positions && a.channels == b.channels && a.aside == b.aside);
    RC_ASSERT(a.num_components == full.components && b.num_components == full.components);
    RC_ASSERT(a.num_levels == b.num_levels && a.base_vertices == b.base_vertices && a.base_faces == b.base_faces);
    uint32_t vertices = a.base_vertices;
    for (uint32_t k = 0; k < a.num_levels; ++k) {
        const cq_level &x = a.level[k], &y = b.level[k];
        vertices += x.num_splits;
        RC_ASSERT(x.num_vertices == vertices && y.num_vertices == vertices);
        RC_ASSERT(x.num_patches == y.num_patches && x.num_splits == y.num_splits);
        RC_ASSERT(x.sum_i == y.sum_i && x.sum_j == y.sum_j);
        RC_ASSERT(x.flags == y.flags && x.indices == y.indices && x.values == y.values);
        RC_ASSERT(x.num_splits > 0u && x.regular == y.regular);
        RC_ASSERT((x.regular ? x.num_patches == 0u : x.num_splits <= x.num_patches));
    }
    RC_ASSERT(vertices == model.mesh.num_vertices);
}

void encoding_twice_gives_the_same_bytes()
{
    Recipe recipe = *any_recipe(2.0);
    Model one(recipe), two(recipe);
    Stream s(one), t(two);
    RC_ASSERT(s.c.result == CQ_OK && t.c.result == CQ_OK);
    RC_ASSERT(bytes_of(s) == bytes_of(t));
}

// The finest mesh of a stream can be encoded again, and what comes out is that mesh.
void a_decoded_mesh_can_be_encoded_again()
{
    Model model(*any_recipe(1.5));
    Stream s(model);
    Decoding d(s);
    RC_ASSERT(decoding_run(&d.d, s.c.bytes, s.c.size, s.c.size, CQ_NO_LIMIT) == CQ_DONE);
    cq_input again = model.input;
    again.indices = d.mesh().origin;
    for (uint32_t k = 0; k < again.shape.num_channels; ++k) again.values[k] = d.d.decoder->channel[k];
    Stream t(again, model);
    RC_ASSERT(t.c.result == CQ_OK);
    std::vector<cq_index> map, face_map;
    for (uint32_t v = 0; v < model.mesh.num_vertices; ++v) map.push_back(t.c.map[s.c.map[v]]);
    for (uint32_t f = 0; f < model.mesh.faces.size(); ++f) face_map.push_back(t.c.face_map[s.c.face_map[f]]);
    Decoding e(t);
    RC_ASSERT(decoding_run(&e.d, t.c.bytes, t.c.size, t.c.size, CQ_NO_LIMIT) == CQ_DONE);
    RC_ASSERT(same_mesh(model, map.data(), face_map.data(), *e.d.decoder));
}

// The encoder meets faces that are no manifold with an error, never with a stream.
void faces_that_are_no_manifold_are_never_encoded()
{
    Recipe recipe = *any_recipe(0.5);
    auto damage = *any_numbers(0.06);
    Sculptor mesh(recipe);
    for (uint32_t number : damage) {
        Random random{number};
        Face &f = mesh.faces[random.below(mesh.faces.size())];
        if (random.below(2) == 0) f[random.below(3)] = random.below(mesh.num_vertices + 1u);
        else std::swap(f[0], f[1]);
    }
    Surface surface = examine(mesh.faces);
    bool good = surface.error == "" && surface.vertices == mesh.num_vertices, in_range = true;
    for (const Face &f : mesh.faces)
        for (uint32_t v : f) in_range = in_range && v < mesh.num_vertices;
    std::vector<cq_index> indices;
    for (const Face &f : mesh.faces)
        for (uint32_t v : f) indices.push_back(static_cast<cq_index>(v));
    cq_input input{};
    input.shape.num_vertices = mesh.num_vertices;
    input.shape.num_faces = static_cast<uint32_t>(mesh.faces.size());
    input.indices = indices.data();
    RC_ASSERT((Stream(input).c.result == CQ_OK) == in_range);
    RC_TAG(good ? "still good" : "damaged");
}

}  // namespace

int main(int argc, char **argv)
{
    Properties property(argc, argv);
    property("decoding gives back the faces and values through the map",
             decoding_gives_back_the_faces_and_values_through_the_map);
    property("both goals give back the same mesh", both_goals_give_back_the_same_mesh);
    property("large meshes come back too", large_meshes_come_back_too);
    property("every step of the decoder leaves a mesh of the same topology",
             every_step_of_the_decoder_leaves_a_mesh_of_the_same_topology);
    property("every prefix of the base is a mesh that only grew", every_prefix_of_the_base_is_a_mesh_that_only_grew);
    property("values never change once they have arrived", values_never_change_once_they_have_arrived);
    property("every prefix is a mesh on the way to the full one", every_prefix_is_a_mesh_on_the_way_to_the_full_one);
    property("any pieces and any budgets give the same mesh", any_pieces_and_any_budgets_give_the_same_mesh);
    property("a decoder can be stopped anywhere and go on later", a_decoder_can_be_stopped_anywhere_and_go_on_later);
    property("flipped bits give an error or a coarser mesh", flipped_bits_give_an_error_or_a_coarser_mesh);
    property("replaced, inserted and missing bytes give an error or a coarser mesh",
             replaced_inserted_and_missing_bytes_give_an_error_or_a_coarser_mesh);
    property("damage with right check values gives an error or a valid mesh",
             damage_with_right_check_values_gives_an_error_or_a_valid_mesh);
    property("noise behind a good header gives an error or a valid mesh",
             noise_behind_a_good_header_gives_an_error_or_a_valid_mesh);
    property("the parts of the report add up and both sides agree",
             the_parts_of_the_report_add_up_and_both_sides_agree);
    property("encoding twice gives the same bytes", encoding_twice_gives_the_same_bytes);
    property("a decoded mesh can be encoded again", a_decoded_mesh_can_be_encoded_again);
    property("faces that are no manifold are never encoded", faces_that_are_no_manifold_are_never_encoded);
    return property.end();
}
