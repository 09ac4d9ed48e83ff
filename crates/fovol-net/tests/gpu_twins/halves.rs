//! Compares f16 storage and arithmetic with f32.

use super::*;
use fovol_net::plan::{Conv, Pool, SpaceToDepth};

/// PSNR between two sequences, in dB.
fn psnr(a: &[Frame], b: &[Frame]) -> f64 {
    let pairs = a.iter().zip(b).flat_map(|(a, b)| a.pixels().iter().zip(b.pixels()));
    let squares: Vec<f64> = pairs.flat_map(|(a, b)| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2))).collect();
    -10.0 * (squares.iter().sum::<f64>() / squares.len() as f64 + 1e-12).log10()
}

/// Number of frames, enough for recurrent errors to grow.
const RECURRENT: u32 = 16;

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn halves_stay_close() {
    for named in Named::ALL {
        let weights = Weights::shipped(named).or_else(|_| Weights::random(&named.config(), 3));
        // Wide networks are slow in software.
        let size = if named == Named::WNetFast { size(75, 50) } else { size(37, 25) };
        let (weights, plan) = (weights.unwrap(), named.config().plan().unwrap());
        let (specification, _) = both(&GPU, &plan, &weights);
        let network = Network::new(&GPU, plan, &weights, Precision::F16).unwrap();
        assert_eq!(network.precision(), Precision::F16);
        let (mut expected_state, mut state) = (specification.state(size), network.state(size).unwrap());
        let mut clips = [Vec::new(), Vec::new()];
        for (sparse, motion) in &clip(size, RECURRENT) {
            let input = FrameInput { sparse: &SparseFrame::from(sparse), motion: motion.as_deref() };
            clips[0].push(specification.reconstruct(&input, &mut expected_state).unwrap());
            clips[1].push(network.reconstruct(&input, &mut state).unwrap());
        }
        let close = psnr(&clips[0], &clips[1]);
        let exact = clips[0] == clips[1];
        println!("{named} f16 over {RECURRENT} frames: {close:.1} dB");
        assert!(close >= 45.0 && !exact, "{named}: {close} dB");
    }
}

/// Two convolutions with f16 tensors, the second reading the first in one of several ways, and a picture made from
/// it.
#[derive(Debug, Clone)]
struct Wide {
    /// Channels of both convolutions.
    channels: [usize; 2],
    /// Window edges of both convolutions.
    sizes: [usize; 2],
    /// Whether the border is replicated; otherwise it is zero.
    replicates: bool,
    reads: u32,
    frame: [u32; 2],
}

fn wide() -> impl Strategy<Value = Wide> {
    let size = || prop_oneof![Just(1usize), Just(3)];
    ((16usize..70, 16usize..70), (size(), size()), any::<bool>(), 0u32..4, (1u32..60, 1u32..40)).prop_map(
        |(channels, sizes, replicates, reads, frame)| Wide {
            channels: channels.into(),
            sizes: sizes.into(),
            replicates,
            reads,
            frame: frame.into(),
        },
    )
}

impl Wide {
    fn plan(&self) -> Plan {
        let mut b = PlanBuilder::new();
        let (colour, mask) = (b.colour(), b.mask());
        let ([first, second], [edge, other]) = (self.channels, self.sizes);
        let given = [Read::same(colour), Read::same(mask)];
        let one = match self.replicates {
            true => b.add(Conv::replicating("one", &given, first, 1, Activation::Elu)),
            false => b.add(Conv::new("one", &given, first, edge, Activation::Elu)),
        };
        let folded = b.add(SpaceToDepth::new(colour));
        let half = b.add(Pool::new(one));
        let reads = match self.reads {
            0 => vec![Read::same(one), Read::same(colour)],
            1 => vec![Read::bilinear(half), Read::same(mask), Read::same(one)],
            2 => vec![Read::same(colour), Read::nearest(half), Read::bilinear(half)],
            _ => vec![Read::same(half), Read::same(folded)],
        };
        let two = b.add(Conv::new("two", &reads, second, other, Activation::Relu));
        let three = match (self.reads, self.replicates) {
            (3, _) => Read::bilinear(two),
            (_, true) => Read::bilinear(b.add(Conv::replicating(
                "three",
                &[Read::same(two)],
                second,
                2,
                Activation::None,
            ))),
            _ => Read::same(b.add(Conv::new(
                "three",
                &[Read::same(two), Read::same(one)],
                second,
                3,
                Activation::None,
            ))),
        };
        let picture = b.add(Conv::new("picture", &[three], 3, 1, Activation::None));
        b.finish(picture)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20, failure_persistence: None, ..Default::default() })]
    /// Runs with cooperative matrices, if the adapter has them, and without.
    #[test]
    #[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
    fn wide_convolutions_of_halves_are_those_of_the_cpu(wide in wide()) {
        let (plan, [w, h]) = (wide.plan(), wide.frame);
        let (weights, sparse) = (random_weights(&plan), SparseFrame::from(&sparse(size(w, h), 3)));
        let input = FrameInput { sparse: &sparse, motion: None };
        let exact = cpu::Network::new(plan.clone(), &weights, cpu::Simd::best(), cpu::Precision::F32).unwrap();
        let expected = exact.reconstruct(&input, &mut exact.state(sparse.size())).unwrap();
        for gpu in [GPU.clone(), GPU.clone().with_matrices(None)] {
            let network = Network::new(&gpu, plan.clone(), &weights, Precision::F16).unwrap();
            let found = network.reconstruct(&input, &mut network.state(sparse.size()).unwrap()).unwrap();
            let difference = difference(&values(&found), &values(&expected));
            prop_assert!(difference <= 4e-3, "{difference} with {:?}", gpu.matrices());
        }
    }
}
