//! Draws that must never change: packings of users depend on them, on every system.

use super::SizeDistribution;
use crate::scene::parse_psd;

/// The uniform numbers that the draws are made from.
const AT: [f64; 3] = [0.1, 0.5, 0.9];

/// A law, and the bits of its draws at [`AT`]: stated by number, stated by volume.
const FROZEN: [(&str, [[u64; 3]; 2]); 10] = [
    (
        r#"kind = "monodisperse"
diameter = 1.7e-3"#,
        [
            [
                0x3f5b_da51_19ce_075f,
                0x3f5b_da51_19ce_075f,
                0x3f5b_da51_19ce_075f,
            ],
            [
                0x3f5b_da51_19ce_075f,
                0x3f5b_da51_19ce_075f,
                0x3f5b_da51_19ce_075f,
            ],
        ],
    ),
    (
        r#"kind = "uniform"
min_diameter = 1e-3
max_diameter = 3e-3"#,
        [
            [
                0x3f53_a92a_3055_3262,
                0x3f60_624d_d2f1_a9fc,
                0x3f66_f006_8db8_bac8,
            ],
            [
                0x3f51_2a24_bac5_68d4,
                0x3f55_fb3f_d343_8790,
                0x3f62_515f_dab8_464e,
            ],
        ],
    ),
    (
        r#"kind = "normal"
mean_diameter = 2e-3
standard_deviation = 2e-4"#,
        [
            [
                0x3f5c_9190_8bbe_3951,
                0x3f60_624d_d2f1_a9fc,
                0x3f62_7bd3_6004_3750,
            ],
            [
                0x3f5b_780e_0fa7_83c8,
                0x3f5f_bee2_0be0_70be,
                0x3f62_012b_6ec1_2f3d,
            ],
        ],
    ),
    (
        r#"kind = "lognormal"
median_diameter = 3e-3
sigma = 0.2"#,
        [
            [
                0x3f63_04f8_1059_c679,
                0x3f68_9374_bc6a_7ef8,
                0x3f6f_c187_1aaf_ddc0,
            ],
            [
                0x3f60_de63_64cc_e031,
                0x3f65_cc05_5cfe_f8f2,
                0x3f6c_2a3e_8ce4_04ce,
            ],
        ],
    ),
    (
        r#"kind = "rosin-rammler"
d63 = 1e-3
exponent = 3.7"#,
        [
            [
                0x3f41_d622_ac81_fcc0,
                0x3f4d_ad7b_ba18_3ea6,
                0x3f54_86cc_51ec_6e06,
            ],
            [
                0x3f06_61aa_8e29_74d4,
                0x3f36_6a0e_3df7_31d4,
                0x3f4c_5471_ca91_0280,
            ],
        ],
    ),
    (
        r#"kind = "ggs"
max_diameter = 1e-3
exponent = 3.2"#,
        [
            [
                0x3f3f_e9f5_99c6_6a04,
                0x3f4a_62e2_d3bc_f410,
                0x3f4f_b4e8_bd55_e2ec,
            ],
            [
                0x3ed4_efd5_a200_b653,
                0x3f1b_7a15_fc46_91b9,
                0x3f46_7a3e_bcb7_b91a,
            ],
        ],
    ),
    (
        r#"kind = "phi-normal"
median_diameter = 1e-3
sigma_phi = 0.4
cut = [0.1, 0.8]"#,
        [
            [
                0x3f49_26ae_8359_d17c,
                0x3f4f_a560_25d3_8044,
                0x3f53_6b12_1a93_985a,
            ],
            [
                0x3f48_1071_4cdb_a84e,
                0x3f4c_bb0e_8c74_3616,
                0x3f52_4906_e11a_58fe,
            ],
        ],
    ),
    (
        r#"kind = "mixture"
of = [
{ share = 0.3, kind = "lognormal", median_diameter = 1e-3, sigma = 0.1 },
{ share = 0.7, kind = "uniform", min_diameter = 2e-3, max_diameter = 3e-3 },
]"#,
        [
            [
                0x3f4f_62f5_707a_0bf4,
                0x3f62_b97d_835d_548e,
                0x3f67_67dc_e434_a9b1,
            ],
            [
                0x3f4c_35b4_96fa_c4bf,
                0x3f50_36a7_3b37_d36d,
                0x3f61_ae6b_723c_4d3b,
            ],
        ],
    ),
    (
        r#"kind = "classes"
diameters = [1e-3, 1.5e-3, 2e-3, 4e-3]
shares = [1.0, 0.0, 2.5]"#,
        [
            [
                0x3f53_404e_a4a8_c155,
                0x3f65_4c98_5f06_f694,
                0x3f6e_7967_caea_747e,
            ],
            [
                0x3f51_5784_92e8_ed06,
                0x3f55_2c5f_92c5_f92c,
                0x3f65_734f_d58d_86b9,
            ],
        ],
    ),
    (
        r#"kind = "classes"
model = "volume-log-uniform"
diameters = [1e-3, 1.5e-3, 2e-3, 4e-3]
shares = [1.0, 0.0, 2.5]"#,
        [
            [
                0x3f52_00da_d0f8_6b41,
                0x3f62_225d_4b19_e6db,
                0x3f6a_1862_9ac4_ffcb,
            ],
            [
                0x3f50_e281_dbc2_0e07,
                0x3f53_c812_16a4_6cd9,
                0x3f63_73f1_a04a_67fe,
            ],
        ],
    ),
];

#[test]
fn draws_never_change() {
    for (law, frozen) in FROZEN {
        for (weighting, expected) in ["number", "volume"].into_iter().zip(frozen) {
            let text = format!("{law}\nweighting = \"{weighting}\"\n");
            let psd = parse_psd("law.toml", &text, None).expect("a law");
            let sizes = SizeDistribution::from_scene(&psd).expect("sizes");
            let drawn = AT.map(|u| sizes.sample_diameter(u));
            assert_eq!(
                drawn.map(f64::to_bits),
                expected,
                "{law} by {weighting}: {drawn:?}"
            );
        }
    }
}
