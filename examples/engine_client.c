/* The engine's side of a channel to Proxima (docs/engine_channel.md): moves an object, and prints what is felt.
 *
 *     proxima touch cube --device hand:press --engine udp:4712      in one terminal
 *     engine_client udp:4712                                        in another
 *
 * C99, POSIX and flock(); of the compiler the atomics of GCC and Clang. struct channel and the functions channel_... are all
 * that a program of your own needs. They take the machine for little-endian, as the packets are. */
#define _POSIX_C_SOURCE 200809L
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <netinet/in.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { VERSION = 2, TOUCH_SIZE = 576, MOST_OBJECTS = 64 };
enum { HAS_POSE = 1, HAS_VELOCITY = 2, HAS_MATERIAL = 4 };

/* A scene packet: a header and its objects. All fields are where the packet has them: there is no padding. */
struct scene_object {
    uint32_t object, flags;
    double position[3], quaternion[4], velocity[3], spin[3]; /* w, x, y, z */
    double stiffness, damping, static_friction, dynamic_friction;
};
struct scene_packet {
    char magic[4];
    uint16_t version, size;
    uint64_t session, sequence, nanoseconds;
    uint32_t count, flags;
    double period, material_seconds;
    uint32_t reply_every, reserved;
    struct scene_object objects[MOST_OBJECTS];
};
struct touch_contact {
    uint32_t object, triangle;
    double position[3], normal[3], pressure;
};
struct touch_packet {
    char magic[4];
    uint16_t version, size;
    uint64_t session, tick, nanoseconds, engine_session, engine_sequence, engine_nanoseconds;
    uint64_t accepted, lost, refused, refused_objects, unsent;
    uint32_t condition, flags, hold, contact_count, buttons, reserved;
    double units_per_metre, center[3], device[3], rotation[4], proxy[3], anchor[3], force[3],
        torque[3];
    double normal[3], depth, surface_velocity[3], force_scale, softness, added_damping;
    struct touch_contact contacts[3];
};
struct ring {
    uint32_t offset, slot_size, slots, count_offset;
};
struct segment_header {
    char magic[4];
    uint16_t version, size;
    uint32_t endianness, flags;
    uint64_t segment_size, owner;
    struct ring touch, scene;
};
typedef char scene_object_has_no_padding[sizeof(struct scene_object) == 144 ? 1 : -1];
typedef char touch_packet_has_no_padding[sizeof(struct touch_packet) == TOUCH_SIZE ? 1 : -1];
typedef char segment_header_has_no_padding[sizeof(struct segment_header) == 64 ? 1 : -1];

struct channel {
    int file;     /* socket or shared memory */
    char* memory; /* null for UDP */
    size_t mapped;
    struct ring touch, scene;
    uint64_t read, written; /* packets of the rings */
    uint64_t session, sequence, last_tick, missed;
};

static uint64_t nanoseconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static int refuse(const char* name, const char* why)
{
    fprintf(stderr, "engine_client: %s: %s\n", name, why);
    return 0;
}

static int open_udp(struct channel* channel, const char* name, const char* rest)
{
    const char* const colon = strrchr(rest, ':');
    char host[16] = "127.0.0.1";
    struct sockaddr_in address;
    if (colon != NULL) {
        if ((size_t)(colon - rest) >= sizeof host) return refuse(name, "is no address");
        memcpy(host, rest, (size_t)(colon - rest));
        host[colon - rest] = '\0';
    }
    memset(&address, 0, sizeof address);
    address.sin_family = AF_INET;
    address.sin_port = htons((uint16_t)atoi(colon != NULL ? colon + 1 : rest));
    if (inet_pton(AF_INET, host, &address.sin_addr) != 1) return refuse(name, "is no address");
    channel->file = socket(AF_INET, SOCK_DGRAM, 0);
    if (channel->file < 0 ||
        connect(channel->file, (struct sockaddr*)&address, sizeof address) != 0)
        return refuse(name, strerror(errno));
    return 1;
}

/* Whether a ring is within the memory, and each slot has room for a number and a packet. */
static int fits(const struct channel* channel, const struct ring* ring, size_t packet_size)
{
    const uint64_t size = (uint64_t)ring->slot_size * ring->slots;
    return ring->slots > 0 && ring->slot_size >= 8 + packet_size && ring->offset % 8 == 0 &&
           ring->slot_size % 8 == 0 && ring->count_offset % 8 == 0 &&
           ring->offset + size <= channel->mapped &&
           (uint64_t)ring->count_offset + 8 <= channel->mapped;
}

/* Null, or what is wrong with the segment. */
static const char* map_segment(struct channel* channel)
{
    static const char* const unfinished = "is no channel of Proxima, or not set up yet";
    struct stat there;
    struct segment_header header;
    struct flock lock;
    uint64_t word;
    /* Proxima holds this lock while it runs. What a killed one left, the next one takes over. */
    if (flock(channel->file, LOCK_SH | LOCK_NB) == 0) {
        flock(channel->file, LOCK_UN);
        return "the program that made it has ended";
    }
    /* One engine at a time. This lock is the process's: it does not keep two channels of one program apart. */
    memset(&lock, 0, sizeof lock);
    lock.l_type = F_WRLCK;
    lock.l_whence = SEEK_SET;
    lock.l_len = 1;
    if (fcntl(channel->file, F_SETLK, &lock) != 0) return "another engine uses it";
    if (fstat(channel->file, &there) != 0 || (size_t)there.st_size < sizeof header)
        return "is not set up yet";
    channel->mapped = (size_t)there.st_size;
    channel->memory =
        mmap(NULL, channel->mapped, PROT_READ | PROT_WRITE, MAP_SHARED, channel->file, 0);
    if (channel->memory == MAP_FAILED) {
        channel->memory = NULL;
        return strerror(errno);
    }
    /* First the flags: where they say that it is open, the rest is written. */
    word = __atomic_load_n((uint64_t*)(channel->memory + 8), __ATOMIC_ACQUIRE);
    memcpy(&header, channel->memory, sizeof header);
    memcpy(&header.endianness, &word, sizeof word);
    if (memcmp(header.magic, "PXSM", 4) != 0 || header.endianness != 0x01020304u ||
        header.segment_size != channel->mapped)
        return unfinished;
    if (header.version != VERSION)
        return "Proxima has another version of the protocol: use two that fit each other";
    if ((header.flags & 1u) == 0) return "the program that made it has ended";
    channel->touch = header.touch;
    channel->scene = header.scene;
    if (!fits(channel, &channel->touch, sizeof(struct touch_packet)) ||
        !fits(channel, &channel->scene, sizeof(struct scene_packet)))
        return unfinished;
    channel->read = __atomic_load_n((uint64_t*)(channel->memory + channel->touch.count_offset),
                                    __ATOMIC_ACQUIRE);
    channel->written = __atomic_load_n((uint64_t*)(channel->memory + channel->scene.count_offset),
                                       __ATOMIC_ACQUIRE);
    return NULL;
}

static void channel_close(struct channel* channel)
{
    if (channel->memory != NULL) munmap(channel->memory, channel->mapped);
    channel->memory = NULL;
    if (channel->file >= 0) close(channel->file);
    channel->file = -1;
}

/* udp:PORT, udp:ADDRESS:PORT or shm:NAME, for which it waits. 0 where it cannot be opened; then it says why. */
static int channel_open(struct channel* channel, const char* name, double patience)
{
    const uint64_t end = nanoseconds_now() + (uint64_t)(1e9 * patience);
    const struct timespec pause = {0, 20000000};
    char path[80];
    memset(channel, 0, sizeof *channel);
    channel->session = nanoseconds_now() ^ (uint64_t)getpid() << 40;
    channel->file = -1;
    if (strncmp(name, "udp:", 4) == 0) return open_udp(channel, name, name + 4);
    if (strncmp(name, "shm:", 4) != 0 || strlen(name) > 68)
        return refuse(name, "is no channel: give udp:PORT, udp:ADDRESS:PORT or shm:NAME");
    sprintf(path, "/proxima-%s", name + 4);
    for (;;) {
        const char* problem = "is not there: start proxima touch ... --engine with that name first";
        channel->file = shm_open(path, O_RDWR, 0);
        if (channel->file >= 0) problem = map_segment(channel);
        if (problem == NULL) return 1;
        channel_close(channel);
        if (nanoseconds_now() > end) return refuse(name, problem);
        nanosleep(&pause, NULL);
    }
}

/* Fills in the header and sends the packet with packet->count objects. */
static void channel_send(struct channel* channel, struct scene_packet* packet)
{
    const size_t size = 64 + packet->count * sizeof(struct scene_object);
    memcpy(packet->magic, "PXSC", 4);
    packet->version = VERSION;
    packet->size = (uint16_t)size;
    packet->session = channel->session;
    packet->sequence = ++channel->sequence;
    packet->nanoseconds = nanoseconds_now();
    if (channel->memory == NULL) {
        if (send(channel->file, packet, size, MSG_DONTWAIT) < 0 && errno != ECONNREFUSED)
            perror("engine_client: send");
    } else {
        const uint64_t number = channel->written++;
        char* const slot = channel->memory + channel->scene.offset +
                           channel->scene.slot_size * (number % channel->scene.slots);
        __atomic_store_n((uint64_t*)slot, 2 * number + 1, __ATOMIC_RELAXED);
        __atomic_thread_fence(__ATOMIC_RELEASE);
        memcpy(slot + 8, packet, size);
        __atomic_store_n((uint64_t*)slot, 2 * number + 2, __ATOMIC_RELEASE);
        __atomic_store_n((uint64_t*)(channel->memory + channel->scene.count_offset), number + 1,
                         __ATOMIC_RELEASE);
    }
}

/* The next touch packet that was not read yet, and counts those that were missed: 1, 0 for none, or -1 for another version. */
static int channel_receive(struct channel* channel, struct touch_packet* packet)
{
    if (channel->memory == NULL) {
        ssize_t size;
        do size = recv(channel->file, packet, sizeof *packet, MSG_DONTWAIT | MSG_TRUNC);
        while (size < 0 && errno == ECONNREFUSED);
        if (size < 0) return 0;
        if (size < 8 || memcmp(packet->magic, "PXTO", 4) != 0 || packet->version != VERSION ||
            size != TOUCH_SIZE)
            return -1;
    } else {
        const uint64_t written = __atomic_load_n(
            (uint64_t*)(channel->memory + channel->touch.count_offset), __ATOMIC_ACQUIRE);
        int whole = 0;
        if (written < channel->read) channel->read = 0; /* Proxima was started anew */
        if (written - channel->read > channel->touch.slots)
            channel->read = written - channel->touch.slots;
        while (!whole && channel->read != written) {
            const uint64_t there = 2 * channel->read + 2;
            char* const slot = channel->memory + channel->touch.offset +
                               channel->touch.slot_size * (channel->read % channel->touch.slots);
            ++channel->read;
            if (__atomic_load_n((uint64_t*)slot, __ATOMIC_ACQUIRE) != there) continue;
            memcpy(packet, slot + 8, sizeof *packet);
            __atomic_thread_fence(__ATOMIC_ACQUIRE);
            whole = __atomic_load_n((uint64_t*)slot, __ATOMIC_RELAXED) == there;
        }
        if (!whole) return 0;
        if (packet->version != VERSION) return -1;
    }
    if (channel->last_tick != 0 && packet->tick > channel->last_tick + 1)
        channel->missed += packet->tick - channel->last_tick - 1;
    channel->last_tick = packet->tick;
    return 1;
}

static int ascending(const void* a, const void* b)
{
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

enum { MOST_DELAYS = 100000, RECENT = 256 };
static double delays[MOST_DELAYS];

int main(int argc, char** argv)
{
    const double seconds = argc > 2 ? atof(argv[2]) : 5, rate = argc > 3 ? atof(argv[3]) : 60,
                 patience = 10;
    const struct timespec pause = {0, 100000};
    struct channel channel;
    struct scene_packet packet;
    struct touch_packet state;
    uint64_t sent_at[RECENT] = {0}, first = 0, heard = 0, next = 0, ticks = 0, touching = 0,
             lost = 0;
    size_t delay_count = 0;
    double most = 0;
    int got = 0;
    if (argc < 2) {
        fprintf(stderr, "usage: engine_client udp:PORT|udp:ADDRESS:PORT|shm:NAME [SECONDS "
                        "[POSES_PER_SECOND]]\n");
        return 2;
    }
    if (!channel_open(&channel, argv[1], patience)) return 1;
    const uint64_t started = nanoseconds_now();
    memset(&packet, 0, sizeof packet);
    packet.reply_every = 1;
    while (first == 0 || 1e-9 * (double)(nanoseconds_now() - first) < seconds) {
        const uint64_t now = nanoseconds_now();
        if (first == 0 && 1e-9 * (double)(now - started) > patience) {
            refuse(argv[1], "nobody answers: is proxima touch ... --engine running there, with "
                            "version 2 of the protocol, and with no other engine?");
            return 1;
        }
        if (first != 0 && now - heard > 2000000000u) {
            puts("Proxima no longer answers");
            break;
        }
        if (now >= next) {
            next = now + (uint64_t)(1e9 / rate);
            packet.count = 1;
            packet.objects[0].flags = HAS_POSE;
            packet.objects[0].position[2] =
                first == 0 ? 0 : 0.1 * sin(3.14159265 * 1e-9 * (double)(now - first));
            packet.objects[0].quaternion[0] = 1;
            sent_at[(channel.sequence + 1) % RECENT] = now;
            channel_send(&channel, &packet);
        }
        while ((got = channel_receive(&channel, &state)) != 0) {
            if (got < 0) {
                refuse(argv[1], "Proxima has another version of the protocol than 2: use two that "
                                "fit each other");
                return 1;
            }
            if (state.engine_session != channel.session) continue;
            heard = nanoseconds_now();
            if (first == 0) first = heard;
            ++ticks;
            touching += state.contact_count > 0;
            lost = state.lost;
            most =
                fmax(most, sqrt(state.force[0] * state.force[0] + state.force[1] * state.force[1] +
                                state.force[2] * state.force[2]));
            if (sent_at[state.engine_sequence % RECENT] != 0 && delay_count < MOST_DELAYS) {
                delays[delay_count++] =
                    1e-6 * (double)(nanoseconds_now() - sent_at[state.engine_sequence % RECENT]);
                sent_at[state.engine_sequence % RECENT] = 0;
            }
        }
        nanosleep(&pause, NULL);
    }
    packet.count = 0;
    packet.flags = 1; /* the engine leaves */
    channel_send(&channel, &packet);
    channel_close(&channel);
    qsort(delays, delay_count, sizeof *delays, ascending);
    printf("%llu ticks received, %llu missed; %llu packets sent, %llu lost\n",
           (unsigned long long)ticks, (unsigned long long)channel.missed,
           (unsigned long long)channel.sequence, (unsigned long long)lost);
    printf("touching in %llu ticks, force at most %.3f N\n", (unsigned long long)touching, most);
    if (delay_count > 0) {
        printf("from a pose to the force of its first tick: p50 %.3f ms, p99 %.3f ms\n",
               delays[delay_count / 2], delays[delay_count * 99 / 100]);
    }
    return 0;
}
