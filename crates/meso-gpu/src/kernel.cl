/* A step of a test, OpenCL C and CUDA: forces of elements, motion of nodes, sums, scalars.
   Every operation is exactly rounded and every sum has the order of meso-solve, so that the bytes are those of the processor. */
#ifdef __CUDACC__
typedef unsigned int uint;
typedef unsigned short ushort;
#define KERNEL(threads) extern "C" __global__ void __launch_bounds__(threads)
/* Groups of 128 threads that share a multiprocessor's registers. */
#define KERNEL_OF_ELEMENTS extern "C" __global__ void __launch_bounds__(THREADS, RESIDENT * 128 / THREADS)
/* Two groups of nodes have the registers for loads; without loads the compiler finds room for four. */
#if LOADS
#define KERNEL_OF_NODES extern "C" __global__ void __launch_bounds__(256, 2)
#else
#define KERNEL_OF_NODES KERNEL(256)
#endif
#define PREFETCH(address) asm volatile("prefetch.global.L2 [%0];" ::"l"(address))
#define GLOBAL
#define LOCAL __shared__
#define NEAR
#define DEVICE __device__ __forceinline__
#define as_float(x) __uint_as_float((uint)(x))
#define as_int(x) __float_as_int(x)
#define GROUP blockIdx.x
#define THREAD threadIdx.x
#define BARRIER __syncthreads()
#define RESTRICT __restrict__
#else
#pragma OPENCL FP_CONTRACT OFF
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#define KERNEL(threads) kernel __attribute__((reqd_work_group_size(threads, 1, 1))) void
#define KERNEL_OF_ELEMENTS KERNEL(THREADS)
#define KERNEL_OF_NODES KERNEL(256)
#define PREFETCH(address)
#define GLOBAL global
#define LOCAL local
#define NEAR local
#define DEVICE
#define GROUP (uint)get_group_id(0)
#define THREAD (uint)get_local_id(0)
#define BARRIER barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE)
#define RESTRICT restrict
#endif

/* Scalars that change (`state`). */
#define STEP 0
#define PROGRESS 1
#define HELD 2
#define SPEED 3
#define TRAVEL 4
#define PACE 5
#define MOST 6
#define SUPPLY 7
#define STORED 8
#define FALL 9
#define EXTERNAL 10
#define INTERNAL 11
#define FRICTION 12
#define KINETIC 13
#define SPENT 14
#define SINCE_ROW 15
#define HALT 19
/* The present step: the whole travel and speed of the path, the pace. */
#define NOW_WHOLE 20
#define NOW_SPEED 21
#define NOW_PACE 22
/* By support in the present step: its place, its mean speed, its pressure. */
#define MOVED 23
#define AT 0
#define MEAN_SPEED 1
#define PRESSURE 2
/* Strain of the mortar without stress, then that of every phase less the mortar's: in the layer, then below it. */
#define FREE (MOVED + 3 * SUPPORTS)

/* Numbers that stay (`rules`). */
#define R_DT 0
#define R_STEPS 1
#define R_STRIDE 2
#define R_SPEED 3
#define R_RAMP 4
#define R_PLATE_ENERGY 5
#define R_RUNAWAY 6
#define R_SERVO 7
#define R_COLLAPSE 8
#define R_SLOWEST 9
#define R_LAG 10
#define R_MEAN 11
#define R_SNAP 12
#define R_SNAPPING 13
#define R_WAY 14
/* By support: its axis, whether the specimen is above it (1) or below (-1), whether it is glued on, its friction, its way. */
#define R_FACES 15
#define AXIS 0
#define INWARD 1
#define GLUED 2
#define RUBS 3
#define MOVES 4
#define PER_SUPPORT 5

/* Counts (`sizes`). */
#define S_NODES 0
#define S_BLOCKS 1
#define S_SPANS 2
#define S_TOUCHES 3
#define S_WATCHED 4

/* Sums of a span: forces of the supports, their work, friction; work of the elements, kinetic energy. */
#define ROWS (SUPPORTS + 4)

/* A support at a node (`kinds`): its number, whether it is the node's last one, whether it is a load and no plate. */
#define SUPPORT 255
#define IS_LAST 256
#define IS_LOAD 512

//LAWS

DEVICE void strain_of(const uint n, GLOBAL const uint* at, GLOBAL const short* g, const float unit, const uint shift, NEAR const float* u,
    float* e) {
  const uint first = 3 * ((at[4 * n] >> shift) & 0xffff);
  const float o0 = u[first], o1 = u[first + 1], o2 = u[first + 2];
  float h00 = 0, h01 = 0, h02 = 0, h10 = 0, h11 = 0, h12 = 0, h20 = 0, h21 = 0, h22 = 0;
#pragma unroll
  for (uint k = 0; k < n; k++) {
    const uint q = 3 * ((at[4 * k] >> shift) & 0xffff);
    const float r0 = u[q] - o0, r1 = u[q + 1] - o1, r2 = u[q + 2] - o2;
    const float a = (float)g[24 * k], b = (float)g[24 * k + 8], c = (float)g[24 * k + 16];
    h00 = fma(r0, a, h00); h01 = fma(r0, b, h01); h02 = fma(r0, c, h02);
    h10 = fma(r1, a, h10); h11 = fma(r1, b, h11); h12 = fma(r1, c, h12);
    h20 = fma(r2, a, h20); h21 = fma(r2, b, h21); h22 = fma(r2, c, h22);
  }
  e[0] = h00 * unit; e[1] = h11 * unit; e[2] = h22 * unit;
  e[3] = (h01 + h10) * unit; e[4] = (h12 + h21) * unit; e[5] = (h02 + h20) * unit;
}

DEVICE void resist(const uint n, GLOBAL const short* g, const float weight, const float* s, NEAR float* f) {
  const float xx = s[0] * weight, yy = s[1] * weight, zz = s[2] * weight;
  const float xy = s[3] * weight, yz = s[4] * weight, zx = s[5] * weight;
  float r0 = 0, r1 = 0, r2 = 0;
#pragma unroll
  for (uint k = 0; k < n; k++) {
    const float a = (float)g[24 * k], b = (float)g[24 * k + 8], c = (float)g[24 * k + 16];
    const float f0 = fma(xx, a, fma(xy, b, zx * c)), f1 = fma(xy, a, fma(yy, b, yz * c)), f2 = fma(zx, a, fma(yz, b, zz * c));
    r0 = r0 - f0; r1 = r1 - f1; r2 = r2 - f2;
    f[8 * k] = f0; f[8 * k + SLOTS] = f1; f[8 * k + 2 * SLOTS] = f2;
  }
  f[8 * n] = r0; f[8 * n + SLOTS] = r1; f[8 * n + 2 * SLOTS] = r2;
}

#ifdef FACE_LAW
/* A cohesive face: pair by pair, the node over the aggregate's and the aggregate's. Returns the energy that it spent. */
DEVICE float face(GLOBAL const float* params, GLOBAL const uint* at, GLOBAL const float* v, const uint shift, NEAR const float* u,
    GLOBAL float* memory, NEAR float* f) {
  const float area = v[0];
  float spent = 0;
  for (uint pair = 0; pair < 3; pair++) {
    const uint over = 3 * ((at[8 * pair] >> shift) & 0xffff), below = 3 * ((at[8 * pair + 4] >> shift) & 0xffff);
    const float apart[6] = {u[over] - u[below], u[over + 1] - u[below + 1], u[over + 2] - u[below + 2], v[8], v[16], v[24]};
    float s[3];
    const float energy = FACE_LAW(params, apart, 0, memory + 40 * pair, s);
    for (uint k = 0; k < 3; k++) {
      const float force = s[k] * area;
      f[16 * pair + k * SLOTS] = force; f[16 * pair + 8 + k * SLOTS] = -force;
    }
    spent = fma(energy, area, spent);
  }
  return spent;
}
#endif

/* Asks for the data and the memory of an eight of the next round. */
DEVICE void fetch(GLOBAL const uint4* eights, GLOBAL const uint* data, GLOBAL const float* memory, const uint lane) {
#ifdef __CUDACC__
  const uint4 eight = *eights;
  const uint n = eight.w & 255, words = 16 * n + 28;
  for (uint word = 8 * lane; word < words; word += 64) PREFETCH(data + eight.x + word);
  PREFETCH(memory + eight.y + 8 * lane);
#endif
}

/* One block of the engine: its nodes' displacements to their shares of the forces, round by round. */
KERNEL_OF_ELEMENTS elements(GLOBAL const uint* RESTRICT blocks, GLOBAL const uint* RESTRICT places, GLOBAL const uint4* RESTRICT eights,
    GLOBAL const uint* RESTRICT data, GLOBAL float* RESTRICT memory, GLOBAL const uint4* RESTRICT rounds,
    GLOBAL const uint* RESTRICT entries, GLOBAL const ushort* RESTRICT slots, GLOBAL const uint* RESTRICT segments,
    GLOBAL const uint* RESTRICT energies, GLOBAL const float* RESTRICT params, GLOBAL const double* RESTRICT u,
    GLOBAL float4* RESTRICT shares, GLOBAL double* RESTRICT dissipated, GLOBAL double* RESTRICT spent, GLOBAL const double* RESTRICT state,
    GLOBAL const double* RESTRICT mm) {
  LOCAL float near_u[3 * PLACES];
  LOCAL float sum[3 * PLACES];
  LOCAL float f[3 * SLOTS];
  LOCAL float spent_of[THREADS];
  LOCAL float volume_of[THREADS];
  LOCAL float energy[8 * ENERGIES];
  if (state[HALT] != 0) return;
  const uint t = THREAD;
  GLOBAL const uint* b = blocks + 8 * GROUP;
  const uint first_place = b[0], count = b[1], first_round = b[2], round_count = b[3], first_eight = b[4], eight_count = b[5];
  const uint first_energy = b[6], energy_count = b[7];
  const uint o = 3 * places[first_place];
  const double o0 = u[o], o1 = u[o + 1], o2 = u[o + 2];
  for (uint i = t; i < count; i += THREADS) {
    const uint node = 3 * places[first_place + i];
#if EXPANDS
    for (uint k = 0; k < 3; k++) near_u[3 * i + k] = (float)(u[node + k] - u[o + k] - state[FREE] * (mm[node + k] - mm[o + k]));
#else
    near_u[3 * i] = (float)(u[node] - o0); near_u[3 * i + 1] = (float)(u[node + 1] - o1); near_u[3 * i + 2] = (float)(u[node + 2] - o2);
#endif
  }
  for (uint i = t; i < 3 * count; i += THREADS) sum[i] = 0;
  for (uint i = t; i < 8 * energy_count; i += THREADS) energy[i] = 0;
  BARRIER;
  for (uint r = 0; r < round_count; r++) {
    const uint4 round = rounds[first_round + r];
    const uint next = r + 1 < round_count ? rounds[first_round + r + 1].y >> 16 : eight_count;
    const uint i = (round.y >> 16) + (t >> 3), lane = t & 7;
    if (i < next) {
      const uint4 eight = eights[first_eight + i];
      const uint n = eight.w & 255, law = (eight.w >> 8) & 15;
      GLOBAL const uint* at = data + eight.x + (lane >> 1);
      GLOBAL const float* v = (GLOBAL const float*)(data + eight.x + 4 * (n + 1) + lane);
      GLOBAL const short* g = (GLOBAL const short*)(data + eight.x + 4 * (n + 1) + 24) + lane;
      const uint shift = (lane & 1) * 16;
      float e[6], s[6];
      switch (n) {
//STRAINS
      }
      fetch(next + (t >> 3) < eight_count ? eights + first_eight + next + (t >> 3) : eights + first_eight + i, data, memory, lane);
      const float width = v[8];
      float volume = v[0], lost = 0;
#if EXPANDS
      const float over = (float)state[FREE + 1 + ((eight.w >> 12) & 15)];
      e[0] = e[0] - over; e[1] = e[1] - over; e[2] = e[2] - over;
#endif
      switch (law) {
//ANSWERS
      }
      spent_of[t] = lost; volume_of[t] = volume;
      switch (n) {
//FORCES
      }
    }
    BARRIER;
    for (uint q = t; q < (round.y & 0xffff); q += THREADS) {
      const uint entry = entries[round.x + q], place = 3 * (entry & 0xffff), end = entries[round.x + q + 1] >> 16;
      float x = sum[place], y = sum[place + 1], z = sum[place + 2];
      for (uint k = entry >> 16; k < end; k++) {
        const uint slot = slots[round.z + k];
        x += f[slot]; y += f[slot + SLOTS]; z += f[slot + 2 * SLOTS];
      }
      sum[place] = x; sum[place + 1] = y; sum[place + 2] = z;
    }
    /* The last threads have the fewest places; they add the energies. */
    const uint back = THREADS - 1 - t, segment = round.w + (back >> 3);
    if (segment < rounds[first_round + r + 1].w) {
      const uint which = segments[segment], lane = back & 7, to = 8 * (which & 0xffff) + lane;
      uint from = (which >> 16) & 255;
      const uint end = from + (which >> 24);
      float x = energy[to];
      for (; from < end; from++) x = fma(spent_of[8 * from + lane], volume_of[8 * from + lane], x);
      energy[to] = x;
    }
    BARRIER;
  }
  for (uint i = t; i < count; i += THREADS) {
    float4 share;
    share.x = sum[3 * i]; share.y = sum[3 * i + 1]; share.z = sum[3 * i + 2]; share.w = 0;
    shares[first_place + i] = share;
  }
  if (t == THREADS - 1) {
    double all = 0;
    for (uint k = 0; k < energy_count; k++) {
      double own = 0;
      for (uint lane = 0; lane < 8; lane++) own += (double)energy[8 * k + lane];
      dissipated[energies[first_energy + k]] += own;
      all += own;
    }
    spent[GROUP] = all;
  }
}

/* Motion of a node along one axis; what plates did to it in this step. */
typedef struct {
  double u, v, rubbed;
  bool is_held;
} Axis;

/* Corrects the velocity of a node that a plate meets, a being the plate's axis; returns the plate's force along it. */
DEVICE double meet(GLOBAL const double* face, const double travel, const double gap, const double dt, const double m,
    Axis* a, Axis* b, Axis* c) {
  const double free_a = a->v, free_b = b->v, free_c = c->v;
  if (face[GLUED] != 0) {
    a->v = (travel - a->u) / dt; b->v = -b->u / dt; c->v = -c->u / dt;
  } else {
    const double inward = face[INWARD], on_plate = travel - inward * gap;
    if ((a->u + dt * a->v - on_plate) * inward >= 0.0) return 0;
    a->v = (on_plate - a->u) / dt;
    const double most = face[RUBS] * fabs(a->v - free_a);
    const double slide_b = b->is_held ? 0.0 : b->v, slide_c = c->is_held ? 0.0 : c->v;
    const double sliding = sqrt(slide_b * slide_b + slide_c * slide_c);
    const double kept = sliding <= most ? 0.0 : 1.0 - most / sliding;
    if (!b->is_held) b->v = b->v * kept;
    if (!c->is_held) c->v = c->v * kept;
  }
  a->is_held = true;
  b->rubbed = b->rubbed + m * (b->v - free_b) / dt;
  c->rubbed = c->rubbed + m * (c->v - free_c) / dt;
  return m * (a->v - free_a) / dt;
}

/* The blocks' force on a node, share by share. */
DEVICE void force_on(const uint i, GLOBAL const uint* node_first, GLOBAL const uint* node_places, GLOBAL const float4* shares, double* f) {
  double x = 0, y = 0, z = 0;
  const uint end = node_first[i + 1];
  for (uint q = node_first[i]; q < end; q++) {
    const float4 share = shares[node_places[q]];
    x = x + (double)share.x; y = y + (double)share.y; z = z + (double)share.z;
  }
  f[0] = x; f[1] = y; f[2] = z;
}

/* Displacements of nodes, and their velocities after a step without supports. */
KERNEL(256) ahead(GLOBAL const uint* RESTRICT count, GLOBAL const double* RESTRICT rules, GLOBAL const uint* RESTRICT node_first,
    GLOBAL const uint* RESTRICT node_places, GLOBAL const float4* RESTRICT shares, GLOBAL const double* RESTRICT mass,
    GLOBAL const double* RESTRICT u, GLOBAL const double* RESTRICT v, GLOBAL const uint* RESTRICT met, GLOBAL double* RESTRICT to) {
  const uint own = GROUP * 256 + THREAD;
  if (own >= count[0]) return;
  const uint i = met[own];
  double f[3];
  force_on(i, node_first, node_places, shares, f);
  const double push = rules[R_DT] / mass[i];
  for (uint k = 0; k < 3; k++) { to[6 * own + k] = u[3 * i + k]; to[6 * own + 3 + k] = v[3 * i + k] - f[k] * push; }
}

/* Nodes sum the blocks' shares and move; loads push them, and plates correct those that they meet. */
KERNEL_OF_NODES nodes(GLOBAL const uint* RESTRICT sizes, GLOBAL const double* RESTRICT rules, GLOBAL const double* RESTRICT state,
    GLOBAL const uint* RESTRICT node_first, GLOBAL const uint* RESTRICT node_places, GLOBAL const float4* RESTRICT shares,
    GLOBAL const double* RESTRICT mass, GLOBAL double* RESTRICT u, GLOBAL double* RESTRICT v, GLOBAL const uint* RESTRICT touch,
    GLOBAL const uint* RESTRICT kinds, GLOBAL const double* RESTRICT numbers, GLOBAL double* RESTRICT work, GLOBAL double* RESTRICT met) {
  const uint i = GROUP * 256 + THREAD;
  if (i >= sizes[S_NODES] || state[HALT] != 0) return;
  const double dt = rules[R_DT];
  double f[3];
  force_on(i, node_first, node_places, shares, f);
  const double f0 = f[0], f1 = f[1], f2 = f[2];
  const double m = mass[i], push = dt / m;
  const double b0 = v[3 * i], b1 = v[3 * i + 1], b2 = v[3 * i + 2];
  Axis x = {u[3 * i], b0 - f0 * push, 0, false}, y = {u[3 * i + 1], b1 - f1 * push, 0, false}, z = {u[3 * i + 2], b2 - f2 * push, 0, false};
  const uint first = touch[i];
  if (first != 0) {
    /* The node's supports, from 1: plates, then loads. */
    const uint all = sizes[S_TOUCHES];
#if LOADS
    double l0 = 0, l1 = 0, l2 = 0;
    uint load = 0;
    for (uint q = first - 1, kind = 0; !(kind & IS_LAST); q++) {
      kind = kinds[q];
      if (kind & IS_LOAD) {
        const double pressure = state[MOVED + 3 * (kind & SUPPORT) + PRESSURE];
        l0 = l0 + pressure * numbers[3 * q]; l1 = l1 + pressure * numbers[3 * q + 1]; l2 = l2 + pressure * numbers[3 * q + 2];
        if (load == 0) load = q + 1;
      }
    }
    if (load != 0) { x.v = x.v + l0 * push; y.v = y.v + l1 * push; z.v = z.v + l2 * push; }
#endif
    for (uint q = first - 1, kind = 0; q == first - 1 || (TOUCHES > 1 && !(kind & IS_LAST)); q++) {
      kind = kinds[q];
      if (LOADS && (kind & IS_LOAD)) break;
      const uint support = kind & SUPPORT;
      GLOBAL const double* face = rules + R_FACES + PER_SUPPORT * support;
      GLOBAL const double* moved = state + MOVED + 3 * support;
      const double axis = face[AXIS], gap = numbers[3 * q];
      double force;
      if (axis == 2) force = meet(face, moved[AT], gap, dt, m, &z, &x, &y);
      else if (axis == 1) force = meet(face, moved[AT], gap, dt, m, &y, &x, &z);
      else force = meet(face, moved[AT], gap, dt, m, &x, &y, &z);
      met[support * all + q] = force;
#if DRIVEN
      const double before = axis == 2 ? b2 : axis == 1 ? b1 : b0, after = axis == 2 ? z.v : axis == 1 ? y.v : x.v;
      met[SUPPORTS * all + q] = 0.5 * dt * force * (before + after);
#else
      met[SUPPORTS * all + q] = force * moved[MEAN_SPEED] * dt;
#endif
    }
    const double mean0 = 0.5 * (x.v + b0), mean1 = 0.5 * (y.v + b1), mean2 = 0.5 * (z.v + b2);
    met[(SUPPORTS + 1) * all + first - 1] = (-dt) * (x.rubbed * mean0 + y.rubbed * mean1 + z.rubbed * mean2);
#if LOADS
    if (load != 0) met[SUPPORTS * all + load - 1] = 0.5 * dt * (l0 * (b0 + x.v) + l1 * (b1 + y.v) + l2 * (b2 + z.v));
#endif
  }
  work[2 * i] = 0.5 * dt * (f0 * (b0 + x.v) + f1 * (b1 + y.v) + f2 * (b2 + z.v));
  work[2 * i + 1] = 0.5 * m * (x.v * x.v + y.v * y.v + z.v * z.v);
  v[3 * i] = x.v; v[3 * i + 1] = y.v; v[3 * i + 2] = z.v;
  u[3 * i] = x.u + dt * x.v; u[3 * i + 1] = y.u + dt * y.v; u[3 * i + 2] = z.u + dt * z.v;
}

#define SUMS 256

/* Adds numbers in their order. */
DEVICE double chain(NEAR const double* a, const uint count, double x) {
  if (count == SUMS) {
#pragma unroll 32
    for (uint i = 0; i < SUMS; i++) x += a[i];
  } else {
    for (uint i = 0; i < count; i++) x += a[i];
  }
  return x;
}

/* Sums over every span of nodes, in their order; the last group sums what the blocks spent. */
KERNEL(SUMS) sums(GLOBAL const uint* RESTRICT sizes, GLOBAL const double* RESTRICT state, GLOBAL const double* RESTRICT work,
    GLOBAL const double* RESTRICT met, GLOBAL const uint* RESTRICT span_touches, GLOBAL const double* RESTRICT spent,
    GLOBAL double* RESTRICT span_sums) {
  LOCAL double own[2][SUMS];
  LOCAL double touched[SUPPORTS + 2][SUMS];
  if (state[HALT] != 0) return;
  const uint t = THREAD, span = GROUP, spans = sizes[S_SPANS];
  double x = 0;
  if (span == spans) {
    const uint blocks = sizes[S_BLOCKS];
    for (uint from = 0; from < blocks; from += SUMS) {
      const uint some = blocks - from < SUMS ? blocks - from : SUMS;
      if (t < some) own[0][t] = spent[from + t];
      BARRIER;
      if (t == 0) x = chain(own[0], some, x);
      BARRIER;
    }
    if (t == 0) span_sums[ROWS * spans] = x;
    return;
  }
  const uint nodes = sizes[S_NODES], all = sizes[S_TOUCHES];
  const uint first = span * SPAN, count = nodes - first < SPAN ? nodes - first : SPAN;
  const uint first_met = span_touches[span], count_met = span_touches[span + 1] - first_met;
  const uint most = count_met > count ? count_met : count;
  for (uint from = 0; from < most; from += SUMS) {
    const uint left = from < count ? count - from : 0, some = left < SUMS ? left : SUMS;
    const uint left_met = from < count_met ? count_met - from : 0, some_met = left_met < SUMS ? left_met : SUMS;
    if (t < some) { own[0][t] = work[2 * (first + from + t)]; own[1][t] = work[2 * (first + from + t) + 1]; }
    if (t < some_met) for (uint k = 0; k < SUPPORTS + 2; k++) touched[k][t] = met[k * all + first_met + from + t];
    BARRIER;
    if (t < 2) x = chain(own[t], some, x);
    if (t >= 32 && t < 34 + SUPPORTS) x = chain(touched[t - 32], some_met, x);
    BARRIER;
  }
  if (t < 2) span_sums[ROWS * span + SUPPORTS + 2 + t] = x;
  if (t >= 32 && t < 34 + SUPPORTS) span_sums[ROWS * span + t - 32] = x;
}

/* Displacements of the nodes under gauges, behind the sums. */
KERNEL(256) watch(GLOBAL const uint* RESTRICT sizes, GLOBAL const uint* RESTRICT watched, GLOBAL const double* RESTRICT u,
    GLOBAL double* RESTRICT span_sums) {
  const uint i = GROUP * 256 + THREAD;
  if (i >= sizes[S_WATCHED]) return;
  GLOBAL double* to = span_sums + ROWS * sizes[S_SPANS] + 1 + 3 * i;
  const uint node = 3 * watched[i];
  to[0] = u[node]; to[1] = u[node + 1]; to[2] = u[node + 2];
}

DEVICE double smaller(const double a, const double b) { return a < b ? a : b; }
DEVICE double larger(const double a, const double b) { return a > b ? a : b; }

/* The motion of the path and of the supports in the next step. */
DEVICE void move(GLOBAL const double* rules, GLOBAL double* state) {
  const double dt = rules[R_DT], steps = rules[R_STEPS], progress = state[PROGRESS];
  const double pace = smaller(state[PACE], steps - progress);
  const double s = smaller((progress * dt + 0.5 * pace * dt) / rules[R_RAMP], 1.0);
  const double speed = pace * (rules[R_SPEED] * s * s * (3.0 - 2.0 * s));
  const double travel = state[TRAVEL] + speed * dt, mean = 0.5 * (speed + state[SPEED]);
  for (uint support = 0; support < SUPPORTS; support++) {
    const double moves = rules[R_FACES + PER_SUPPORT * support + MOVES];
    state[MOVED + 3 * support + AT] = moves * travel;
    state[MOVED + 3 * support + MEAN_SPEED] = moves * mean;
  }
  state[NOW_WHOLE] = travel;
  state[NOW_SPEED] = speed;
  state[NOW_PACE] = pace;
}

/* Before the first step of a batch. */
KERNEL(1) begin(GLOBAL const double* RESTRICT rules, GLOBAL double* RESTRICT state) {
  state[HALT] = 0;
  move(rules, state);
}

DEVICE double due(const double taken, const double steps) { return floor(taken / steps); }
DEVICE bool is_finite(const double x) { return fabs(x) <= 1.7976931348623157e308; }

/* The servo follows a step. */
DEVICE void follow(GLOBAL const double* rules, GLOBAL double* state, const double stored, const double spent, const double supplied) {
  const double steps = rules[R_STEPS];
  const double most = larger(state[MOST], stored);
  state[MOST] = most;
  const double supply = state[SUPPLY] + (supplied - state[SUPPLY]) * rules[R_MEAN];
  state[SUPPLY] = supply;
  const double released = (spent - larger(supply, 0.0)) * steps;
  const double bound = rules[R_COLLAPSE] * most, ratio = bound / released;
  const double held = released > bound ? larger(ratio * ratio, rules[R_SLOWEST]) : 1.0;
  const double fell = state[STORED] - stored + smaller(supplied, 0.0);
  state[STORED] = stored;
  const double fall = state[FALL] + (fell - state[FALL] * (state[PACE] / steps)) / rules[R_WAY];
  state[FALL] = fall;
  const double usual = rules[R_SNAP] * most;
  const double snaps = fall > usual ? larger(usual / fall, rules[R_SNAPPING]) : 1.0;
  state[PACE] = state[PACE] + (smaller(held, snaps) - state[PACE]) * rules[R_LAG];
}

/* Ends a step: sums over spans, scalars, the servo, whether something is due, and the next step's motion. */
KERNEL(64) scalars(GLOBAL const uint* RESTRICT sizes, GLOBAL const double* RESTRICT rules, GLOBAL const double* RESTRICT span_sums,
    GLOBAL double* RESTRICT state) {
  LOCAL double total[ROWS];
  LOCAL double near_sums[ROWS * 64];
  if (state[HALT] != 0) return;
  const uint t = THREAD, spans = sizes[S_SPANS];
  double x = 0;
  for (uint from = 0; from < spans; from += 64) {
    const uint some = spans - from < 64 ? spans - from : 64;
    for (uint i = t; i < ROWS * some; i += 64) near_sums[i] = span_sums[ROWS * from + i];
    BARRIER;
    if (t < ROWS) for (uint i = 0; i < some; i++) x += near_sums[ROWS * i + t];
    BARRIER;
  }
  if (t < ROWS) total[t] = x;
  BARRIER;
  if (t != 0) return;
  const double spent = span_sums[ROWS * spans], progress = state[PROGRESS], held = state[HELD];
  state[SINCE_ROW] += total[0];
  state[SINCE_ROW + 1] += total[1];
  state[SINCE_ROW + 2] += state[TRAVEL];
  state[SINCE_ROW + 3] += 1.0;
  const double done = total[SUPPORTS], rubbed = total[SUPPORTS + 1];
  state[EXTERNAL] += done;
  state[FRICTION] += rubbed;
  state[INTERNAL] += total[SUPPORTS + 2];
  state[KINETIC] = total[SUPPORTS + 3];
  state[TRAVEL] = state[NOW_WHOLE];
  state[SPEED] = state[NOW_SPEED];
  state[STEP] += 1.0;
  state[PROGRESS] = progress + state[NOW_PACE];
  state[HELD] = held + (1.0 - state[NOW_PACE]);
  state[SPENT] += spent;
  if (rules[R_SERVO] != 0) {
    follow(rules, state, state[EXTERNAL] - state[FRICTION] - state[SPENT], spent, done - rubbed);
  }
  const double steps = rules[R_STEPS], stride = rules[R_STRIDE];
  const double most = rules[R_RUNAWAY] * larger(fabs(state[EXTERNAL]), rules[R_PLATE_ENERGY]);
  const bool is_sound = is_finite(state[INTERNAL]) && is_finite(state[EXTERNAL]) && is_finite(state[FRICTION])
      && is_finite(state[KINETIC]) && state[KINETIC] <= most;
  const bool is_over = state[PROGRESS] >= steps;
  const bool is_row = due(state[PROGRESS], stride) + due(state[HELD], stride) > due(progress, stride) + due(held, stride);
  if (!is_sound || is_over || is_row) state[HALT] = 1;
  move(rules, state);
}
