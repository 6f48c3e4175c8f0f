// An LSTM of 256 units over packed sequences, forward and backward, for one core with AMX-BF16 and
// AVX-512. Each function takes raw arrays; packed_lstm.py allocates them and calls.
//
// Shapes: B sequences by falling length, T steps, active[t] of them still running at step t,
// F = sum of active. Packed arrays hold the rows of step 0, then those of step 1, and so on.
// Gate order i, f, g, o as in torch. Products are taken in bfloat16 and summed in float32; `exact`
// splits every factor into two bfloat16, which leaves an error of some 2^-16.

#include <immintrin.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <initializer_list>

namespace {

typedef uint16_t bf16;
const int HIDDEN = 256, GATES = 4 * HIDDEN;
const int TILE = 16;       // rows of a tile, and float32 columns
const int DEPTH = 32;      // bfloat16 columns of a tile
const int BLOCK = TILE * DEPTH;  // elements of a tile
const int UNIT_BLOCKS = HIDDEN / TILE;
const int SAVED = 6 * TILE;  // i, f, g, o, tanh c, c of 16 units, kept for the way back

struct __attribute__((packed)) TileConfig {
  uint8_t palette = 1, start = 0, reserved[14] = {};
  uint16_t bytes[16] = {64, 64, 64, 64, 64, 64, 64, 64};
  uint8_t rows[16] = {16, 16, 16, 16, 16, 16, 16, 16};
};

struct Tiles {  // the tile registers belong to us while this lives
  Tiles() { TileConfig config; _tile_loadconfig(&config); }
  ~Tiles() { _tile_release(); }
};

template <class T>
struct Array {  // zeroed, aligned to a cache line
  T* data;
  explicit Array(size_t n) {
    size_t bytes = (n * sizeof(T) + 63) / 64 * 64;
    data = static_cast<T*>(aligned_alloc(64, bytes));
    memset(data, 0, bytes);
  }
  ~Array() { free(data); }
  Array(const Array&) = delete;
  operator T*() { return data; }
};

bf16 round_bf16(float x) {
  uint32_t bits;
  memcpy(&bits, &x, 4);
  return (bits + 0x7fff + ((bits >> 16) & 1)) >> 16;
}

float widen(bf16 x) {
  uint32_t bits = uint32_t(x) << 16;
  float value;
  memcpy(&value, &bits, 4);
  return value;
}

inline __m512 load_bf16(const bf16* p) {
  __m256i half = _mm256_loadu_si256((const __m256i*)p);
  return _mm512_castsi512_ps(_mm512_slli_epi32(_mm512_cvtepu16_epi32(half), 16));
}

inline __m256i to_bf16(__m512 x) { return (__m256i)_mm512_cvtneps_pbh(x); }
inline void store_bf16(bf16* p, __m512 x) { _mm256_storeu_si256((__m256i*)p, to_bf16(x)); }

inline __m512 exp2_ps(__m512 x) {  // 2^x: a polynomial on [-1/2, 1/2]
  __m512 n = _mm512_roundscale_ps(x, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
  __m512 f = _mm512_sub_ps(x, n);
  __m512 p = _mm512_set1_ps(1.535336188319500e-4f);
  for (float c : {1.339887440266574e-3f, 9.618437357674640e-3f, 5.550332471162809e-2f,
                  2.402264791363012e-1f, 6.931472028550421e-1f, 1.0f})
    p = _mm512_fmadd_ps(p, f, _mm512_set1_ps(c));
  return _mm512_scalef_ps(p, n);
}

inline __m512 inverse_of_one_plus_exp2(__m512 x) {
  __m512 d = _mm512_add_ps(_mm512_set1_ps(1.f),
                           exp2_ps(_mm512_min_ps(x, _mm512_set1_ps(120.f))));
  __m512 r = _mm512_rcp14_ps(d);  // one step of Newton makes 28 bits of 14
  return _mm512_mul_ps(r, _mm512_fnmadd_ps(d, r, _mm512_set1_ps(2.f)));
}

const float LOG2_E = 1.4426950408889634f;

inline __m512 sigmoid(__m512 x) {
  return inverse_of_one_plus_exp2(_mm512_mul_ps(x, _mm512_set1_ps(-LOG2_E)));
}

inline __m512 tanh_ps(__m512 x) {
  __m512 s = inverse_of_one_plus_exp2(_mm512_mul_ps(x, _mm512_set1_ps(-2 * LOG2_E)));
  return _mm512_fmsub_ps(_mm512_set1_ps(2.f), s, _mm512_set1_ps(1.f));
}

// Where row r, columns 16 c .. 16 c + 15 of a matrix of `depths` x 32 columns lie in its tiles.
inline long in_tiles(int r, int c, int depths) {
  return long(r / TILE * depths + c / 2) * BLOCK + r % TILE * DEPTH + c % 2 * TILE;
}

struct Factor {  // of a product: tiles, the rest that rounding left (or null), and tiles a block
  const bf16 *high, *low;
  int depths;
  Factor block(int n) const {
    long offset = long(n) * depths * BLOCK;
    return {high + offset, low ? low + offset : nullptr, depths};
  }
};

inline void two_by_two(bool both) {
  _tile_dpbf16ps(0, 4, 6);
  _tile_dpbf16ps(1, 4, 7);
  if (both) {
    _tile_dpbf16ps(2, 5, 6);
    _tile_dpbf16ps(3, 5, 7);
  }
}

// One or two tiles of rows times two blocks of columns; out[row][column] are the 16 x 16 results.
inline void multiply(Factor a, bool both, Factor w0, Factor w1, float* const out[2][2]) {
  Factor b = both ? a.block(1) : a;
  _tile_zero(0);
  _tile_zero(1);
  _tile_zero(2);
  _tile_zero(3);
  for (long k = 0; k < long(a.depths) * BLOCK; k += BLOCK) {
    _tile_loadd(6, w0.high + k, 64);
    _tile_loadd(7, w1.high + k, 64);
    if (a.low) {
      _tile_loadd(4, a.low + k, 64);
      if (both) _tile_loadd(5, b.low + k, 64);
      two_by_two(both);
    }
    _tile_loadd(4, a.high + k, 64);
    if (both) _tile_loadd(5, b.high + k, 64);
    two_by_two(both);
    if (a.low) {
      _tile_loadd(6, w0.low + k, 64);
      _tile_loadd(7, w1.low + k, 64);
      two_by_two(both);
    }
  }
  _tile_stored(0, out[0][0], 64);
  _tile_stored(1, out[0][1], 64);
  if (both) {
    _tile_stored(2, out[1][0], 64);
    _tile_stored(3, out[1][1], 64);
  }
}

// The tile of weights that multiplies `depth` rows into columns: pairs of rows side by side.
template <class Get>
void pack_weights(bf16* high, bf16* low, Get get) {
  for (int pair = 0; pair < TILE; pair++)
    for (int column = 0; column < TILE; column++)
      for (int j = 0; j < 2; j++) {
        float value = get(2 * pair + j, column);
        int at = pair * DEPTH + 2 * column + j;
        high[at] = round_bf16(value);
        if (low) low[at] = round_bf16(value - widen(high[at]));
      }
}

}  // namespace

// Linux gives a process the tile registers only when it asks. Returns 0 when they are ours.
extern "C" int use_tiles() {
  const int ARCH_REQ_XCOMP_PERM = 0x1023, XFEATURE_XTILEDATA = 18;
  return syscall(SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) != 0;
}

// first, later: (B, 4H) what the input adds to the gates at step 0 and after; weight: (4H, H).
// Out: h (F, H); h_before (F - B, H), the h that steps 1.. started from; saved (F, 6 H), opaque.
// The last two may be null where no way back is wanted.
extern "C" void forward(const float* first, const float* later, const float* weight,
                        const int* active, int T, int exact, float* h, bf16* h_before,
                        bf16* saved) {
  Tiles tiles;
  const int B = active[0], row_tiles = (B + 2 * TILE - 1) / (2 * TILE) * 2;
  const int depths = HIDDEN / DEPTH;
  Array<bf16> w_high(GATES * HIDDEN), w_low(GATES * HIDDEN);  // block 4 u + q: gate q of units u
  for (int u = 0; u < UNIT_BLOCKS; u++)
    for (int q = 0; q < 4; q++)
      for (int k = 0; k < depths; k++) {
        long at = long((u * 4 + q) * depths + k) * BLOCK;
        const float* from = weight + long(q * HIDDEN + TILE * u) * HIDDEN + DEPTH * k;
        pack_weights(w_high + at, w_low + at,
                     [&](int row, int column) { return from[column * HIDDEN + row]; });
      }
  Array<float> x_first(B * GATES), x_later(B * GATES);  // (units u, row, gate, 16)
  for (int u = 0; u < UNIT_BLOCKS; u++)
    for (int r = 0; r < B; r++)
      for (int q = 0; q < 4; q++) {
        long to = ((u * B + r) * 4 + q) * TILE, from = r * GATES + q * HIDDEN + TILE * u;
        memcpy(x_first + to, first + from, 64);
        memcpy(x_later + to, later + from, 64);
      }
  Array<float> c(B * HIDDEN), z(4 * row_tiles * TILE * TILE);
  Array<bf16> high0(row_tiles * TILE * HIDDEN), high1(row_tiles * TILE * HIDDEN);
  Array<bf16> low0(row_tiles * TILE * HIDDEN), low1(row_tiles * TILE * HIDDEN);
  bf16 *h_high[2] = {high0, high1}, *h_low[2] = {low0, low1};
  Factor w = {w_high, exact ? w_low.data : nullptr, depths};
  long offset = 0;
  for (int t = 0; t < T; t++) {
    const int n = active[t], now = t & 1, next = now ^ 1;
    Factor a = {h_high[now], exact ? h_low[now] : nullptr, depths};
    for (int u = 0; u < UNIT_BLOCKS; u++) {
      for (int m = 0; t > 0 && m * TILE < n; m += 2)
        for (int q = 0; q < 4; q += 2) {
          float* z0 = z + (q * row_tiles + m) * 256;
          float* z1 = z + ((q + 1) * row_tiles + m) * 256;
          float* const out[2][2] = {{z0, z1}, {z0 + 256, z1 + 256}};
          multiply(a.block(m), (m + 1) * TILE < n, w.block(4 * u + q), w.block(4 * u + q + 1), out);
        }
      const float* x = (t ? x_later : x_first) + u * B * 4 * TILE;
      for (int r = 0; r < n; r++) {
        __m512 gate[4];
        for (int q = 0; q < 4; q++) {
          gate[q] = _mm512_load_ps(x + (4 * r + q) * TILE);
          if (t) gate[q] = _mm512_add_ps(gate[q], _mm512_load_ps(z + (q * row_tiles * TILE + r) * TILE));
        }
        __m512 i = sigmoid(gate[0]), f = sigmoid(gate[1]), g = tanh_ps(gate[2]), o = sigmoid(gate[3]);
        float* c_at = c + (u * B + r) * TILE;
        __m512 cell = _mm512_fmadd_ps(f, _mm512_load_ps(c_at), _mm512_mul_ps(i, g));
        _mm512_store_ps(c_at, cell);
        __m512 tanh_c = tanh_ps(cell), out = _mm512_mul_ps(o, tanh_c);
        _mm512_storeu_ps(h + (offset + r) * HIDDEN + u * TILE, out);
        long at = in_tiles(r, u, depths);
        store_bf16(h_high[next] + at, out);
        if (exact)
          store_bf16(h_low[next] + at, _mm512_sub_ps(out, load_bf16(h_high[next] + at)));
        if (saved) {
          bf16* to = saved + (offset * UNIT_BLOCKS + long(u) * n + r) * SAVED;
          const __m512 values[6] = {i, f, g, o, tanh_c, cell};
          for (int v = 0; v < 6; v++) store_bf16(to + v * TILE, values[v]);
        }
      }
    }
    if (h_before && t + 1 < T)
      for (int r = 0; r < active[t + 1]; r++)
        for (int k = 0; k < depths; k++)
          memcpy(h_before + (offset + n - B + r) * HIDDEN + k * DEPTH,
                 h_high[next] + in_tiles(r, 2 * k, depths), 64);
    offset += n;
  }
}

// grad_h: (F, H). Out: grad_gates (F, 4H); grad_first, grad_later (B, 4H).
extern "C" void backward(const float* grad_h, const float* weight, const int* active, int T,
                         const bf16* saved, bf16* grad_gates, float* grad_first,
                         float* grad_later) {
  Tiles tiles;
  const int B = active[0], row_tiles = (B + 2 * TILE - 1) / (2 * TILE) * 2;
  const int depths = GATES / DEPTH;
  Array<bf16> w_tiles(GATES * HIDDEN);
  for (int u = 0; u < UNIT_BLOCKS; u++)
    for (int k = 0; k < depths; k++) {
      const float* from = weight + long(DEPTH * k) * HIDDEN + TILE * u;
      pack_weights(w_tiles + long(u * depths + k) * BLOCK, nullptr,
                   [&](int row, int column) { return from[row * HIDDEN + column]; });
    }
  Array<float> grad_c(B * HIDDEN), later(B * GATES), recurrent(row_tiles * TILE * HIDDEN);
  Array<bf16> gates(row_tiles * TILE * GATES);
  Factor a = {gates, nullptr, depths}, w = {w_tiles, nullptr, depths};
  const __m512 one = _mm512_set1_ps(1.f);
  auto slope = [&](__m512 s) { return _mm512_mul_ps(s, _mm512_sub_ps(one, s)); };  // of sigmoid
  long offset = 0;
  for (int t = 0; t < T; t++) offset += active[t];
  for (int t = T - 1; t >= 0; t--) {
    const int n = active[t], before = t ? active[t - 1] : 0;
    offset -= n;
    for (int u = 0; u < UNIT_BLOCKS; u++)
      for (int r = 0; r < n; r++) {
        const bf16* s = saved + (offset * UNIT_BLOCKS + long(u) * n + r) * SAVED;
        const bf16* s_before =
            saved + ((offset - before) * UNIT_BLOCKS + long(u) * before + r) * SAVED;
        __m512 i = load_bf16(s), f = load_bf16(s + 16), g = load_bf16(s + 32);
        __m512 o = load_bf16(s + 48), tanh_c = load_bf16(s + 64);
        __m512 c_before = t ? load_bf16(s_before + 80) : _mm512_setzero_ps();
        __m512 dh = _mm512_add_ps(_mm512_loadu_ps(grad_h + (offset + r) * HIDDEN + u * TILE),
                                  _mm512_load_ps(recurrent + (u * row_tiles * TILE + r) * TILE));
        float* dc_at = grad_c + (u * B + r) * TILE;
        __m512 dc = _mm512_fmadd_ps(_mm512_mul_ps(dh, o), _mm512_fnmadd_ps(tanh_c, tanh_c, one),
                                    _mm512_load_ps(dc_at));
        _mm512_store_ps(dc_at, _mm512_mul_ps(dc, f));
        const __m512 d[4] = {_mm512_mul_ps(_mm512_mul_ps(dc, g), slope(i)),
                             _mm512_mul_ps(_mm512_mul_ps(dc, c_before), slope(f)),
                             _mm512_mul_ps(_mm512_mul_ps(dc, i), _mm512_fnmadd_ps(g, g, one)),
                             _mm512_mul_ps(_mm512_mul_ps(dh, tanh_c), slope(o))};
        for (int q = 0; q < 4; q++) {
          float* sum = later + ((u * B + r) * 4 + q) * TILE;
          if (t)
            _mm512_store_ps(sum, _mm512_add_ps(d[q], _mm512_load_ps(sum)));
          else
            _mm512_storeu_ps(grad_first + r * GATES + q * HIDDEN + u * TILE, d[q]);
          store_bf16(gates + in_tiles(r, q * UNIT_BLOCKS + u, depths), d[q]);
        }
      }
    for (int r = 0; r < n; r++)
      for (int k = 0; k < depths; k++)
        memcpy(grad_gates + (offset + r) * GATES + k * DEPTH, gates + in_tiles(r, 2 * k, depths), 64);
    for (int m = 0; t > 0 && m * TILE < n; m += 2)
      for (int u = 0; u < UNIT_BLOCKS; u += 2) {
        float* r0 = recurrent + (u * row_tiles + m) * 256;
        float* r1 = recurrent + ((u + 1) * row_tiles + m) * 256;
        float* const out[2][2] = {{r0, r1}, {r0 + 256, r1 + 256}};
        multiply(a.block(m), (m + 1) * TILE < n, w.block(u), w.block(u + 1), out);
      }
  }
  for (int u = 0; u < UNIT_BLOCKS; u++)
    for (int r = 0; r < B; r++)
      for (int q = 0; q < 4; q++)
        memcpy(grad_later + r * GATES + q * HIDDEN + u * TILE, later + ((u * B + r) * 4 + q) * TILE, 64);
}
