//! Tables as laboratories write them: read rightly, or refused with the line and the reason.

use meso_core::import::sieve_table::{Choices, Meaning, SieveTable, SieveUnit, TableColumn, ValueUnit, read};

fn table(text: &str) -> Result<SieveTable, String> {
    read(text.as_bytes(), &Choices::default())
}

/// Sieves, mm, and per cent that pass.
type Curve = &'static [(f64, f64)];

fn is_near(table: &SieveTable, curve: Curve, within: f64) -> bool {
    table.sieves_mm.len() == curve.len()
        && table
            .sieves_mm
            .iter()
            .zip(&table.passing)
            .zip(curve)
            .all(|((sieve, share), row)| (sieve - row.0).abs() < 1e-12 && (100.0 * share - row.1).abs() < within)
}

const GERMAN: Curve = &[(0.25, 8.0), (1.0, 21.5), (4.0, 40.2), (8.0, 62.0), (16.0, 95.5), (31.5, 100.0)];
const ASTM: Curve = &[(0.15, 2.0), (0.3, 12.0), (0.6, 38.0), (1.18, 63.0), (2.36, 85.0), (4.75, 98.0), (9.5, 100.0)];
const STONE: Curve = &[(4.0, 0.0), (8.0, 20.0), (16.0, 80.0), (31.5, 100.0)];

const WASHED: Curve = &[(4.0, 20.0), (8.0, 60.0), (11.2, 85.0), (16.0, 100.0)];

/// Name of the sheet, its text, and the curve that it has.
const READ: [(&str, &str, Curve); 72] = [
    (
        "EN 933-1, German",
        "\u{feff}Prüfbericht Nr.;4711\r\nSieb (mm);Durchgang (%)\r\n31,5;100\r\n16;95,5\r\n8;62,0\r\n4;40,2\r\n1;21,5\r\n0,25;8,0\r\n",
        GERMAN,
    ),
    (
        "units in a row of their own",
        "Maschenweite;Siebdurchgang\nmm;M.-%\n0,25;8,0\n1,0;21,5\n4,0;40,2\n8,0;62,0\n16,0;95,5\n31,5;100,0\n",
        GERMAN,
    ),
    (
        "tabs and an extra column",
        "Sieve size (mm)\tPassing (%)\tRemark\n31.5\t100\t\n16\t95.5\tflaky\n8\t62\n4\t40.2\n1\t21.5\n0.25\t8\n",
        GERMAN,
    ),
    (
        "quoted decimal commas",
        "\"Tamis (mm)\",\"Passant (%)\"\n\"31,5\",\"100,0\"\n\"16,0\",\"95,5\"\n\"8,0\",\"62,0\"\n\"4,0\",\"40,2\"\n\"1,0\",\"21,5\"\n\"0,25\",\"8,0\"\n",
        GERMAN,
    ),
    ("shares", "sieve_mm,passing\n0.25,0.08\n1,0.215\n4,0.402\n8,0.62\n16,0.955\n31.5,1\n", GERMAN),
    ("percent signs in cells", "Sieve mm,Finer\n0.25,8%\n1,21.5 %\n4,40.2%\n8,62%\n16,95.5%\n31.5,100%\n", GERMAN),
    (
        "cumulative retained, Spanish",
        "Tamiz (mm);Retenido acumulado (%)\n31,5;0\n16;4,5\n8;38,0\n4;59,8\n1;78,5\n0,25;92,0\nFondo;100\n",
        GERMAN,
    ),
    (
        "cumulative retained without a pan",
        "Siebweite [mm];Rückstand kumuliert [%]\n31,5;0\n16;4,5\n8;38\n4;59,8\n1;78,5\n0,25;92\n",
        GERMAN,
    ),
    (
        "retained on each sieve with a pan, Polish",
        "Sito [mm];Pozostałość na sicie [%]\n31,5;0\n16;4,5\n8;33,5\n4;21,8\n1;18,7\n0,25;13,5\ndno;8,0\n",
        GERMAN,
    ),
    (
        "masses with a pan",
        "Sieve (mm),Mass retained (g)\n31.5,0\n16,90\n8,670\n4,436\n1,374\n0.25,270\nPan,160\nTotal,2000\n",
        GERMAN,
    ),
    (
        "masses with thousands",
        "Sieve (mm);Mass retained (g)\n31.5;0\n16;900\n8;6,700\n4;4,360\n1;3,740\n0.25;2,700\nPan;1,600\nTotal;20,000\n",
        GERMAN,
    ),
    (
        "masses with spaces, French",
        "Tamis (mm);Refus partiel (g)\n31,5;0\n16;900\n8;6 700\n4;4 360\n1;3 740\n0,25;2 700\nFond;1 600\n",
        GERMAN,
    ),
    (
        "masses that add up",
        "Tamis (mm);Refus cumulés (g)\n31,5;0\n16;90\n8;760\n4;1196\n1;1570\n0,25;1840\nFond;2000\n",
        GERMAN,
    ),
    (
        "ASTM C136, inches and numbers",
        "Sieve,Percent passing\n3/8 in.,100\nNo. 4,98\nNo. 8,85\nNo. 16,63\nNo. 30,38\nNo. 50,12\nNo. 100,2\nFineness modulus,3.02\n",
        ASTM,
    ),
    (
        "ASTM, numbers with mm",
        "U.S. sieve,% passing\n\"3/8\"\" (9.5 mm)\",100\n#4 (4.75 mm),98\n#8 (2.36 mm),85\n#16 (1.18 mm),63\n#30 (0.600 mm),38\n#50 (0.300 mm),12\n#100 (0.150 mm),2\n",
        ASTM,
    ),
    (
        "ASTM worksheet of four columns",
        "Sieve size,Mass retained (g),Percent retained,Cumulative percent retained,Percent passing\n9.5 mm,0.0,0.0,0.0,100.0\n4.75 mm,10.0,2.0,2.0,98.0\n2.36 mm,65.0,13.0,15.0,85.0\n1.18 mm,110.0,22.0,37.0,63.0\n600 µm,125.0,25.0,62.0,38.0\n300 µm,130.0,26.0,88.0,12.0\n150 µm,50.0,10.0,98.0,2.0\nPan,10.0,2.0,100.0,\n",
        ASTM,
    ),
    (
        "IS 2386 sheet",
        "IS Sieve,Weight retained (g),% weight retained,Cumulative % weight retained,% passing\n10 mm,Nil,Nil,Nil,100\n4.75 mm,20,2,2,98\n2.36 mm,130,13,15,85\n1.18 mm,220,22,37,63\n600 micron,250,25,62,38\n300 micron,260,26,88,12\n150 micron,100,10,98,2\nPan,20,2,100,-\n",
        &[(0.15, 2.0), (0.3, 12.0), (0.6, 38.0), (1.18, 63.0), (2.36, 85.0), (4.75, 98.0), (10.0, 100.0)],
    ),
    (
        "BS 882 with limits",
        "BS sieve (mm);Passing (%);Lower limit (%);Upper limit (%)\n31.5;100;100;100\n16;80;75;95\n8;20;10;30\n4;0;0;5\n",
        STONE,
    ),
    ("micrometres in the heading", "Sieve (µm);Passing (%)\n31500;100\n16000;80\n8000;20\n4000;0\n", STONE),
    ("Russian", "Размер отверстий сит, мм;Полный остаток, %\n31,5;0\n16;20\n8;80\n4;100\n", STONE),
    ("Chinese", "筛孔尺寸(mm),通过百分率(%)\n31.5,100\n16,80\n8,20\n4,0\n", STONE),
    (
        "Italian",
        "Setaccio (mm);Trattenuto parziale (%);Trattenuto cumulato (%);Passante (%)\n31,5;0;0;100\n16;20;20;80\n8;60;80;20\n4;20;100;0\n",
        STONE,
    ),
    (
        "Portuguese, masses and sum",
        "Peneira (mm);Massa retida (g)\n31,5;0\n16;200\n8;600\n4;200\nFundo;0\nSoma;1000\n",
        STONE,
    ),
    ("Dutch", "Zeef (mm);Doorval (%)\n31,5;100\n16;80\n8;20\n4;0\n", STONE),
    ("Swedish", "Sikt (mm)\tPasserande (%)\n31,5\t100\n16\t80\n8\t20\n4\t0\n", STONE),
    ("no heading", "31.5;100\n16;80\n8;20\n4;0\n", STONE),
    ("words that mean nothing", "A,B\n31.5,100\n16,80\n8,20\n4,0\n", STONE),
    ("spaces", "# from the quarry\nsieve_mm  passing_percent\n4   0\n8   20\n16  80\n31.5  100\n", STONE),
    (
        "a table of text",
        "| Sieve (mm) | Passing (%) |\n|---|---|\n| 31.5 | 100 |\n| 16 | 80 |\n| 8 | 20 |\n| 4 | 0 |\n",
        STONE,
    ),
    ("sieves in a row", "Sieb (mm);4;8;16;31,5\nDurchgang (%);0;20;80;100\n", STONE),
    (
        "two columns of sieves",
        "Sieve (in),Opening (mm),Passing (%)\n1 1/2,37.5,100\n3/4,19.0,80\n3/8,9.5,20\nNo. 4,4.75,0\n",
        &[(4.75, 0.0), (9.5, 20.0), (19.0, 80.0), (37.5, 100.0)],
    ),
    (
        "inches in the heading",
        "Sieve (in),Passing (%)\n1-1/2,100\n3/4,80\n3/8,20\n0.187,0\n",
        &[(4.75, 0.0), (9.5, 20.0), (19.0, 80.0), (37.5, 100.0)],
    ),
    ("counted rows", "No.,Sieve mm,Passing %\n1,31.5,100\n2,16,80\n3,8,20\n4,4,0\n", STONE),
    (
        "blank cells beyond the ends",
        "Sieve (mm);Passing (%)\n45;\n31.5;100\n16;80\n8;20\n4;0\n2;\n",
        &[(2.0, 0.0), (4.0, 0.0), (8.0, 20.0), (16.0, 80.0), (31.5, 100.0), (45.0, 100.0)],
    ),
    (
        "shares of the blend in the table",
        "Sieve (mm);Sand;Gravel\nShare (%);40;60\n16;100;100\n8;100;50\n4;95;0\n2;50;0\n",
        &[(2.0, 20.0), (4.0, 38.0), (8.0, 70.0), (16.0, 100.0)],
    ),
    (
        "decimals that could be thousands elsewhere",
        "Sieve (mm);Passing (%)\n31.500;100.000\n16.000;80.000\n8.000;20.000\n4.000;0\n",
        STONE,
    ),
    (
        "EN 933-1 sheet",
        "Laboratory: Kies AG;;;\nSample mass (g);2500,4;;\n;;;\nSieve opening;Mass retained R_i;Percentage retained;Cumulative passing\nmm;g;%;%\n31,5;0,0;0,0;100\n16;112,5;4,5;95,5\n8;837,5;33,5;62\n4;545;21,8;40,2\n1;467,5;18,7;21,5\n0,25;337,5;13,5;8\nP (pan);200;8;\nSum;2500;;\nLoss (%);;;\n",
        GERMAN,
    ),
    ("sum of the percent retained", "Sieve (mm);Retained (%)\n31.5;0\n16;20\n8;60\n4;20\n<4;0\nTotal;100\n", STONE),
    ("Turkish", "Elek açıklığı (mm);Geçen (%)\n31,5;100\n16;80\n8;20\n4;0\n", STONE),
    ("Japanese", "ふるい目(mm),通過質量百分率(%)\n31.5,100\n16,80\n8,20\n4,0\n", STONE),
    ("Korean, cumulative retained", "체 크기 (mm),누적 잔류율 (%)\n31.5,0\n16,20\n8,80\n4,100\n", STONE),
    ("Korean, retained", "체 크기 (mm),잔류율 (%)\n31.5,0\n16,20\n8,60\n4,20\n", STONE),
    ("Vietnamese", "Cỡ sàng (mm);Lượng sót tích lũy (%)\n31,5;0\n16;20\n8;80\n4;100\n", STONE),
    ("Hebrew, retained", "נפה (mm);נשאר (%)\n31.5;0\n16;20\n8;60\n4;20\n", STONE),
    ("Arabic digits", "فتحة المنخل (مم);المار (%)\n٣١٫٥;١٠٠\n١٦;٨٠\n٨;٢٠\n٤;٠\n", STONE),
    ("Persian digits", "الک (mm)\tدرصد عبوری\n۳۱٫۵\t۱۰۰\n۱۶\t۸۰\n۸\t۲۰\n۴\t۰\n", STONE),
    ("full-width letters", "筛孔尺寸（ｍｍ），通过率（％）\n３１．５，１００\n１６，８０\n８，２０\n４，０\n", STONE),
    (
        "thousands of three kinds",
        "Tamis (mm);Refus partiel (g)\n31,5;0\n16;2\u{a0}000\n8;6\u{202f}000\n4;2'000\nFond;0\n",
        STONE,
    ),
    ("masses of 1.234,5", "Sieb (mm);Rückstand (g)\n31,5;0,0\n16;1.234,5\n8;3.703,5\n4;1.234,5\nSchale;0,0\n", STONE),
    ("values before sieves", "Passing (%);Sieve (mm)\n100;31.5\n80;16\n20;8\n0;4\n", STONE),
    ("units in the cells alone", "Sieb;Durchgang\n31,5mm;100 %\n16mm;80 %\n8mm;20 %\n4mm;0 %\n", STONE),
    ("a spreadsheet's separator in line 1", "sep=;\nSieve (mm);Passing (%)\n31.5;100\n16;80\n8;20\n4;0\n", STONE),
    (
        "empty fields and lines",
        "Sieve (mm);Passing (%);;;\n\n31.5;100;;;\n;;;;\n16;80;;;\n8;20;;;\n\n4;0;;;\n;;;;\n",
        STONE,
    ),
    (
        "exponents",
        "Sieve (mm);Passing (%)\n3.15E+01;1.00E+02\n1.60E+01;8.00E+01\n8.00E+00;2.00E+01\n4.00E+00;0.00E+00\n",
        STONE,
    ),
    ("lines in a heading", "\"Sieve\n(mm)\";\"Passing\n(%)\"\n31.5;100\n16;80\n8;20\n4;0\n", STONE),
    ("lines of an old spreadsheet", "Sieve (mm);Passing (%)\r31.5;100\r16;80\r8;20\r4;0\r", STONE),
    (
        "curves of a standard beside it",
        "Sieb (mm);Grenzsieblinie A32;Grenzsieblinie B32;Durchgang (%)\n31,5;100;100;100\n16;62;80;80\n8;38;62;20\n4;23;47;0\n",
        STONE,
    ),
    ("a range beside it", "Sieve (mm);Specified;Passing (%)\n31.5;100;100\n16;75-85;80\n8;15-25;20\n4;0-5;0\n", STONE),
    ("figures below", "Sieve (mm);Passing (%)\n31.5;100\n16;80\n8;20\n4;0\nD50;11.3\nCu;2.1\n", STONE),
    (
        "empty sieves weighed",
        "Sieve (mm);Sieve + sample (g);Empty sieve (g);Retained (g)\n31.5;500;500;0\n16;700;500;200\n8;1100;500;600\n4;700;500;200\nPan;400;400;0\n",
        STONE,
    ),
    (
        "moisture and a date",
        "Sieve (mm);Retained on each sieve (g);Moisture (%);Date\n31.5;0;1.2;2026-01-12\n16;200;1.1;2026-01-12\n8;600;1.0;2026-01-12\n4;200;0.9;2026-01-12\nPan;0;0.8;2026-01-12\n",
        STONE,
    ),
    (
        "abbreviated headings",
        "Sieve mm,Wt Ret (gm),Cum Wt Ret (gm),% Pass.\n31.5,0,0,100\n16,400,400,80\n8,1200,1600,20\n4,400,2000,0\n",
        STONE,
    ),
    (
        "inches with fractions of one letter",
        "Sieve;Passing (%)\n1¼ in;100\n⅝ in;80\n⅜ in;20\nNo. 4;0\n",
        &[(4.75, 0.0), (9.5, 20.0), (16.0, 80.0), (31.5, 100.0)],
    ),
    ("a pan of 0 mm", "Sieve (mm);Retained (%)\n31.5;0\n16;20\n8;60\n4;20\n0;0\n", STONE),
    // EN 933-1: all shares are of the initial mass, 1000 g, and the fines are those of washing and pan.
    (
        "a loss of exactly 1 %",
        "Sieve (mm),Mass retained (g)\n16,0\n11.2,150\n8,250\n4,400\nPan,190\nTotal,1000\n",
        WASHED,
    ),
    (
        "washed-out fines",
        "Sieve (mm),Mass retained (g)\n16,0\n11.2,150\n8,250\n4,400\nPan,150\nWashing loss,50\n",
        WASHED,
    ),
    (
        "washed-out fines without a pan",
        "Sieve (mm);Mass retained (g)\n16;0\n11.2;150\n8;250\n4;400\nFiner than 63 um by washing;200\n",
        WASHED,
    ),
    (
        "initial and final mass below the sieves",
        "Sieve (mm);Mass retained (g)\n16;0\n11.2;150\n8;250\n4;400\nPan;145\nFines washed out;50\nFinal mass M2 (g);950\nInitial mass M1 (g);1000\n",
        WASHED,
    ),
    (
        "initial mass and mass after washing above the sieves",
        "Sieve (mm);Mass retained (g)\nInitial dry mass M1;1000\nDry mass after washing M2;950\nFines by washing;50\n16;0\n11.2;150\n8;250\n4;400\nPan;150\n",
        WASHED,
    ),
    (
        "initial mass and mass after washing above the heading",
        "Initial dry mass M1 (g);1000\nDry mass after washing M2 (g);950\nSieve (mm);Mass retained (g)\n16;0\n11.2;150\n8;250\n4;400\nPan;145\n",
        WASHED,
    ),
    (
        "masses of the test above a column in per cent",
        "Initial mass (g);;1000\nSieve (mm);Mass retained (g);Passing (%)\n16;0;100\n11.2;150;85\n8;250;60\n4;400;20\nPan;195;0\n",
        WASHED,
    ),
    (
        "washed-out fines in per cent, German",
        "Sieb (mm);Rückstand einzeln (%)\n16;0\n11,2;15\n8;25\n4;40\nSchale;15\nAbgeschlämmt, ausgewaschen;5\n",
        WASHED,
    ),
];

#[test]
fn tables_of_laboratories_are_read_as_they_are_meant() {
    let misread = READ.iter().filter_map(|(name, text, curve)| match table(text) {
        Ok(table) if is_near(&table, curve, 1e-9) => None,
        other => Some(format!("{name}: {other:?}\n")),
    });
    assert_eq!(misread.collect::<String>(), "");
}

/// Name of the sheet, its text, and words of the refusal.
const REFUSED: [(&str, &str, &[&str]); 63] = [
    (
        "a loss of 1.1 %",
        "Sieve (mm),Mass retained (g)\n16,0\n11.2,150\n8,250\n4,400\nPan,189\nInitial mass,1000\n",
        &["all rows sum to 989, but the row of the sum has 1000"],
    ),
    (
        "washed-out fines beside masses added up",
        "Sieve (mm);Cumulative mass retained (g)\n16;0\n8;600\n4;900\nPan;950\nWashed out;50\n",
        &["line 6: 50 of fines were washed out", "read that column"],
    ),
    (
        "washed-out fines with a sign",
        "Sieve (mm);Mass retained (g)\n16;0\n8;400\n4;400\nPan;150\nWashing loss;-50\n",
        &["line 6: \"-50\""],
    ),
    (
        "a pan with a slip of the keys",
        "Sieve (mm);Mass retained (g)\n16;0\n8;400\n4;400\nPan;2o0\nTotal;1000\n",
        &["line 5: \"2o0\""],
    ),
    (
        "initial mass above the heading, of which a tenth is missing",
        "Initial mass;1000\nSieve (mm);Mass retained (g)\n16;0\n8;400\n4;400\nPan;100\n",
        &["all rows sum to 900, but the row of the sum has 1000"],
    ),
    (
        "a row that nobody knows",
        "Sieve (mm);Mass retained (g)\n16;0\n8;600\n4;300\nPan;100\nDust;50\n",
        &["line 6: \"Dust\" names no sieve"],
    ),
    (
        "shares under per cent",
        "sieve_mm,passing_percent\n4,0\n8,0.45\n16,1\n",
        &["no number is above 1", "Passing (share)"],
    ),
    ("per cent under shares", "Sieve (mm),Passing (share)\n4,0\n8,45\n16,100\n", &["line 4", "100 is more than 1"]),
    (
        "retained, but which",
        "Sieve (mm);Retained (%)\n16;5\n8;20\n4;30\n",
        &["cumulative retained", "retained on each sieve", "means ="],
    ),
    (
        "passing that falls",
        "Sieve (mm);Passing (%)\n16;0\n8;40\n4;90\n",
        &["line 3: 40 at 8 mm after 0 at 16 mm", "more passes a wider sieve"],
    ),
    ("a curve that dips", "Sieve (mm),Passing (%)\n16,100\n8,40\n4,45\n2,10\n", &["line 4: 45 at 4 mm"]),
    ("a sum of 110", "Sieve (mm);Retained on each sieve (%)\n16;20\n8;60\n4;20\nPan;10\n", &["sum to 110"]),
    (
        "masses without their sum",
        "Sieve (mm);Mass retained (g)\n16;90\n8;670\n4;436\n",
        &["the whole mass is not known", "Pan or Total"],
    ),
    (
        "a sum that is another's",
        "Sieve (mm);Mass retained (g)\n16;90\n8;670\n4;436\nPan;100\nTotal;2000\n",
        &["sum to 1296", "2000"],
    ),
    (
        "two aggregates",
        "Sieve (mm);0/4;4/8\n8;100;100\n4;95;10\n2;60;0\n",
        &["\"0/4\" and column 3 \"4/8\"", "blend = {"],
    ),
    (
        "two aggregates that pass",
        "Sieve (mm);Sand passing (%);Gravel passing (%)\n8;100;100\n4;95;10\n2;60;0\n",
        &["can be the grading", "column ="],
    ),
    (
        "decimal commas between commas",
        "Sieb,Durchgang\n31,5,100\n16,0,80\n8,0,20\n",
        &["line 2: it has 3 fields where 2", ";"],
    ),
    (
        "columns that disagree",
        "Sieve (mm);Cumulative retained (%);Passing (%)\n16;0;100\n8;40;60\n4;90;20\n",
        &["line 4", "disagree at 4 mm", "20 and 10"],
    ),
    (
        "a sieve twice",
        "Sieve (mm);Passing (%)\n16;100\n8;60\n8;50\n4;0\n",
        &["line 4: the sieve of 8 mm stands in line 3"],
    ),
    ("a class for a sieve", "Class (mm);Mass (%)\n4/8;40\n8/16;60\n", &["line 2: \"4/8\" names no sieve"]),
    (
        "a sieve that is none",
        "Sieve (mm);Passing (%)\n16;100\ncoarse;90\n8;60\n",
        &["line 3: \"coarse\" names no sieve"],
    ),
    ("a number that is none", "Sieve (mm);Passing (%)\n16;100\n8;6o\n4;0\n", &["line 3", "\"6o\" is not a number"]),
    ("a bound for a number", "Sieve (mm);Passing (%)\n16;100\n8;60\n4;<1\n", &["line 4", "\"<1\" is not a number"]),
    ("a hole", "Sieve (mm);Passing (%)\n16;100\n8;\n4;20\n", &["line 3: no number for the sieve of 8 mm"]),
    ("sieves of no unit", "Sieve,Passing (%)\n17,100\n9,60\n5,10\n", &["no unit of the sieves", "sieve_unit"]),
    ("inches or millimetres", "Sieve,Passing (%)\n2,100\n1,60\n0.5,10\n", &["no unit of the sieves"]),
    (
        "numbers of other sieves",
        "BS sieve,Passing (%)\nNo. 7,100\nNo. 52,40\nNo. 100,5\n",
        &["\"no. 52\" is no sieve number of ASTM E11"],
    ),
    ("numbers read as mm", "Sieve,Passing (%)\n4,100\n8,80\n16,50\n50,10\n", &["more passes a wider sieve"]),
    (
        "thousands or decimals",
        "Sieve (mm);Mass retained (g)\n16;1.250\n8;2.500\n4;1.000\nPan;1.125\n",
        &["line 2", "is 1.250 or 1250"],
    ),
    (
        "masses that are added up, or not",
        "Sieve (mm);Retained mass (g)\n16;0\n8;400\n4;900\nPan;1000\n",
        &["cumulative retained in masses", "retained on each sieve in masses"],
    ),
    ("a workbook", "PK\u{3}\u{4}rest", &["it is a workbook"]),
    ("nothing", "", &["it has no two columns"]),
    ("one column", "Sieve (mm)\n16\n8\n", &["it has no"]),
    (
        "a pan of another sieve",
        "Sieve (mm);Retained (%)\n16;40\n8;40\n<4;20\n",
        &["all below 4 mm", "finest sieve has 8 mm"],
    ),
    ("more than all", "Sieve (mm);Passing (%)\n16;101\n8;60\n4;0\n", &["line 2: 101 is more than 100"]),
    (
        "two sieves in a cell",
        "Sieve,Passing (%)\n3/4 in (9.5 mm),100\nNo. 4 (4.75 mm),50\nNo. 8 (2.36 mm),0\n",
        &["line 2", "two sieves"],
    ),
    ("dates of a spreadsheet", "Sieve (mm);Passing (%)\n16;100\n11.Feb;80\n8;60\n", &["line 3", "names no sieve"]),
    (
        "a table over two pages",
        "Sieve (mm);Passing (%)\n31.5;100\n16;80\nSieve (mm);Passing (%)\n8;20\n4;0\n",
        &["line 4: a second heading, below the sieves from line 2 on"],
    ),
    (
        "two samples, one below the other",
        "Sample A\nSieve (mm);Passing (%)\n16;100\n8;20\n4;0\n\nSample B\nSieve (mm);Passing (%)\n16;100\n8;30\n4;5\n",
        &["line 8: a second heading, below the sieves from line 3 on"],
    ),
    (
        "sand above gravel",
        "Sand\nSieve (mm);Passing (%)\n4;100\n2;60\n1;0\n\nGravel\nSieve (mm);Passing (%)\n31.5;100\n16;90\n8;0\n",
        &["line 8: a second heading"],
    ),
    (
        "two samples side by side",
        "Sieve (mm);Passing (%);;Sieve (mm);Passing (%)\n16;100;;16;100\n8;20;;8;30\n4;0;;4;5\n",
        &["can be the grading", "blend"],
    ),
    (
        "tests and their mean",
        "Sieve (mm);Test 1 (%);Test 2 (%);Mean (%)\n16;100;100;100\n8;18;22;20\n4;0;0;0\n",
        &["column 4 \"Mean (%)\" can be the grading", "column ="],
    ),
    (
        "shares in the headings",
        "Sieve (mm);Sand 0/4 (40 %);Gravel 4/16 (60 %)\n16;100;100\n8;100;50\n4;95;0\n",
        &["blend = {"],
    ),
    ("sieves in cm", "Sieve (cm);Passing (%)\n3.15;100\n1.6;80\n0.8;20\n0.4;0\n", &["line 2", "\"cm\""]),
    ("sieves in m", "Sieve size (m);Passing (%)\n0.0315;100\n0.016;80\n0.008;20\n0.004;0\n", &["line 2", "\"m\""]),
    ("phi for sieves", "Phi;Finer (%)\n-5;100\n-4;80\n-3;20\n-2;0\n", &["line 2", "\"phi\""]),
    (
        "a slip in the first sieve",
        "Sieve;Retained (g)\n3l.5 mm;200\n16 mm;200\n8 mm;400\n4 mm;200\nPan;0\n",
        &["line 2: \"3l.5\" is not a number"],
    ),
    (
        "a slip in the first sieve, without a unit",
        "Sieve (mm);Retained (g)\n3l.5;200\n16;200\n8;400\n4;200\nPan;0\n",
        &["line 2: \"3l.5\" names no sieve"],
    ),
    (
        "a word for the first sieve",
        "Sieve (mm);Retained (g)\ncoarse;200\n16;200\n8;400\n4;200\nPan;0\n",
        &["line 2: \"coarse\" names no sieve"],
    ),
    ("classes with a dash", "Fraction;Mass (%)\n4-8;20\n8-16;60\n16-31.5;20\n", &["line 2: \"4-8\" names no sieve"]),
    (
        "traces",
        "Sieve (mm);Retained (g)\n16;n/a\n8;600\n4;200\nPan;trace\n",
        &["line 2: no number for the sieve of 16 mm"],
    ),
    (
        "a mark behind a number",
        "Sieve (mm);Passing (%)\n16;100\n8;80*\n4;0\n* repeated\n",
        &["line 3: \"80*\" is not a number"],
    ),
    ("an error beside a number", "Sieve (mm);Passing (%)\n16;100\n8;80 ± 0.4\n4;0\n", &["line 3", "is not a number"]),
    ("a negative mass", "Sieve (mm);Retained (g)\n16;0\n8;-600\n4;200\nPan;0\n", &["line 3: \"-600\" is not a number"]),
    ("masses that pass", "Sieve (mm);Mass passing (g)\n16;2000\n8;400\n4;0\n", &["need the whole mass", "per cent"]),
    ("per mille", "Sieve (mm);Passing (‰)\n16;1000\n8;200\n4;0\n", &["line 2: 1000 is more than 100"]),
    ("a loss of 2 %", "Sieve (mm);Retained on each sieve (%)\n16;20\n8;58\n4;20\nPan;0\n", &["sum to 98, not 100"]),
    (
        "masses in g and kg",
        "Sieve (mm);Mass retained\n16;200 g\n8;0.6 kg\n4;200 g\nPan;0 g\n",
        &["line 3: \"0.6 kg\" is in kg, and line 2 is not"],
    ),
    (
        "fines of a wet sieve",
        "Sieve (mm);Passing (%)\n16;100\n8;20\n4;0\nFiner than 75 µm by washing;0.2\n",
        &["line 5"],
    ),
    ("a range for a number", "Sieve (mm);Passing (%)\n16;100\n8;75-85\n4;0\n", &["line 3: \"75-85\""]),
    ("no number at all", "Sieve (mm);Passing (%)\n16;100\n8;NaN\n4;0\n", &["line 3: \"nan\" is not a number"]),
    // The line was taken for a comment, and its sieve was lost.
    (
        "an error of a spreadsheet for a sieve",
        "Sieve (mm),Passing (%)\n16,100\n#N/A,70\n4,20\n",
        &["line 3: \"#n/a\" is no sieve"],
    ),
    (
        "a division by nothing",
        "Sieve (mm);Passing (%)\n16;100\n#DIV/0!;70\n4;20\n",
        &["line 3: \"#div/0!\" is no sieve"],
    ),
];

#[test]
fn tables_that_could_mean_two_things_are_refused_with_a_reason() {
    let wrong = REFUSED.iter().filter_map(|(name, text, parts)| match table(text) {
        Err(reason) if parts.iter().all(|part| reason.contains(part)) => None,
        other => Some(format!("{name}: {other:?}\n")),
    });
    assert_eq!(wrong.collect::<String>(), "");
}

#[test]
fn a_choice_reads_a_table_that_alone_could_mean_two_things() {
    let retained = "Sieve (mm);Retained (%)\n16;0\n8;20\n4;30\n";
    let means = |means| read(retained.as_bytes(), &Choices { means: Some(means), ..Choices::default() }).unwrap();
    assert!(is_near(&means(Meaning::Cumulative), &[(4.0, 70.0), (8.0, 80.0), (16.0, 100.0)], 1e-9));
    assert!(is_near(&means(Meaning::Retained), &[(4.0, 50.0), (8.0, 80.0), (16.0, 100.0)], 1e-9));
    let bare = "Sieve,Passing (%)\n2,100\n1,60\n0.5,10\n";
    let unit =
        |unit| read(bare.as_bytes(), &Choices { sieve_unit: Some(unit), ..Choices::default() }).unwrap().sieves_mm;
    assert_eq!(unit(SieveUnit::Mm), [0.5, 1.0, 2.0]);
    assert_eq!(unit(SieveUnit::Inch), [12.5, 25.0, 50.0]);
    let share = Choices { unit: Some(ValueUnit::Share), ..Choices::default() };
    assert_eq!(read(b"Sieve (mm),Passing\n8,0.9\n4,0.1\n", &share).unwrap().passing, [0.1, 0.9]);
}

#[test]
fn aggregates_in_columns_are_blended_by_their_shares() {
    let text = "Sieve (mm);Sand 0/4;Gravel 4/8;Grit\n8;100;100;100\n4;95;10;50\n2;60;0;0\n";
    let blend = |columns: &[(&str, f64)]| {
        let columns = columns.iter().map(|(name, share)| (TableColumn::Heading((*name).to_owned()), *share)).collect();
        read(text.as_bytes(), &Choices { columns, ..Choices::default() })
    };
    let table = blend(&[("sand 0/4", 40.0), ("Gravel", 60.0)]).unwrap();
    assert!(is_near(&table, &[(2.0, 24.0), (4.0, 44.0), (8.0, 100.0)], 1e-9), "{table:?}");
    assert!(table.understood.contains("40 % of column 2 \"Sand 0/4\" is passing, in per cent"), "{}", table.understood);
    assert!(blend(&[("Stone", 1.0)]).unwrap_err().contains("no column \"Stone\" of numbers; it has column 2"));
    assert!(blend(&[("Gr", 1.0)]).unwrap_err().contains("2 columns are called \"Gr\""));
    let numbered = "Sieve (mm);1;2\n16;100;100\n8;60;70\n4;10;20\n";
    let second = Choices { columns: vec![(TableColumn::Heading("2".to_owned()), 1.0)], ..Choices::default() };
    assert_eq!(read(numbered.as_bytes(), &second).unwrap().passing, [0.2, 0.7, 1.0]);
    let third = Choices { columns: vec![(TableColumn::Position(3), 1.0)], ..Choices::default() };
    assert_eq!(read(text.as_bytes(), &third).unwrap().passing, [0.0, 0.1, 1.0]);
}

#[test]
fn text_of_spreadsheets_is_read_in_their_encodings() {
    let text = "Maschenweite (mm)\tRückstand kumuliert (%)\n16\t0\n8\t40\n4\t100\n";
    let expected = table(text).unwrap();
    let wide: Vec<u8> = [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert_eq!(read(&wide, &Choices::default()).unwrap(), expected);
    let narrow: Vec<u8> = text.chars().map(|letter| u8::try_from(u32::from(letter)).unwrap()).collect();
    assert_eq!(read(&narrow, &Choices::default()).unwrap(), expected);
}
