// statistics.hpp - what the paper counts. SPDX-License-Identifier: MIT
//
// All rates are bits per vertex that is removed: the unit of the paper's bounds. Of the models of its Table 1 nearly
// all vertices are.
#ifndef FACE_COLLAPSE_STATISTICS_HPP
#define FACE_COLLAPSE_STATISTICS_HPP

#include "codec.hpp"

// The paper's appendix: the largest entropy of integers from 0 on with this mean.
inline double largest_entropy(double mean)
{
    return mean > 0 ? (mean + 1) * std::log2(mean + 1) - mean * std::log2(mean) : 0;
}

class Histogram {
public:
    void add(size_t value) {
        counts[value]++;
        total++;
    }
    size_t count(size_t value) const { return counts.count(value) ? counts.at(value) : 0; }
    double share(size_t value) const { return total > 0 ? double(count(value)) / double(total) : 0; }
    double mean() const {
        double sum = 0;
        for (const auto &c : counts) sum += double(c.first) * double(c.second);
        return total > 0 ? sum / double(total) : 0;
    }
    // Of all values together: what they take if only their frequencies are known.
    double bits() const {
        double sum = 0;
        for (const auto &c : counts) sum += double(c.second) * std::log2(double(total) / double(c.second));
        return sum;
    }

private:
    std::map<size_t, size_t> counts;
    size_t total = 0;
};

struct Statistics {
    size_t vertices = 0, base_vertices = 0, levels = 0, patches = 0, blocked = 0, removed = 0, bytes = 0;
    Histogram size;                                            // of runs; 0: isolated
    std::array<std::array<Histogram, MAX_ENDS>, MAX_RUN> index;   // by the size of the run: i, j, k

    Statistics(const Mesh &mesh, const Simplifier &s, const Stream &stream)
        : vertices(mesh.num_real()), base_vertices(s.mesh.num_real()), levels(s.levels.size()),
          removed(vertices - base_vertices), bytes(stream.bytes.size()) {
        for (const Level &level : s.levels)
            for (const Patch &patch : level) add(patch);
    }

    double isolated() const { return 100 * size.share(0); }
    double out_of_reach() const { return isolated() - per_cent(blocked, patches); }   // no run of available vertices
    double left() const { return per_cent(base_vertices, vertices); }
    double in_pairs() const { return per_cent(2 * size.count(2), removed); }

    double indices() const {
        double sum = 0;
        for (const auto &of_size : index)
            for (const Histogram &h : of_size) sum += h.bits();
        return per_removed(sum);
    }
    double flags() const { return per_removed(size.bits()); }
    double order0() const { return indices() + flags(); }
    double contexts() const { return per_removed(8 * double(bytes)); }

    double sum_of_means(size_t s) const {
        double sum = 0;
        for (const Histogram &h : index[s - 1]) sum += h.mean();
        return sum;
    }
    // Of splits by s: the paper's formula at the means that were measured.
    double formula(size_t s) const {
        double sum = 0;
        for (const Histogram &h : index[s - 1]) sum += largest_entropy(h.mean());
        return sum / double(s);
    }

private:
    void add(const Patch &patch) {
        size_t s = patch.run.size;
        patches++;
        blocked += patch.is_blocked;
        size.add(s);
        if (s == 0) return;
        index[s - 1][0].add(patch.run.ends[0]);
        index[s - 1][1].add(patch.ring_size - 1 - patch.run.ends[s]);
        if (s == 2) index[s - 1][2].add(patch.run.ends[1] - patch.run.ends[0]);
    }

    double per_removed(double bits) const { return removed > 0 ? bits / double(removed) : 0; }
    static double per_cent(size_t part, size_t whole) { return whole > 0 ? 100 * double(part) / double(whole) : 0; }
};

#endif
